// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "web/http_client.hpp"
#include <evermap/web/web_server.hpp>

namespace evermap {
namespace {

/// Says what it was asked.
void echo(const WebRequest& request, const WebRespond& respond) {
  if (request.path == "/throw") throw std::runtime_error("broken");
  respond({200, "text/plain", request.method + " " + request.path + " " + request.body});
}

WebOptions anywhere() {
  WebOptions options;
  options.port = 0;
  return options;
}

template <class Holds>
bool soon(Holds&& holds) {
  for (int i = 0; i < 1000 && !holds(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return holds();
}

TEST(WebServer, HandsRequestsOver) {
  const WebServer server(anywhere(), echo);
  const std::string answer = ask(server.port(), "GET /a/b?c=d");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 OK")) << answer;
  EXPECT_NE(answer.find("\r\n\r\nGET /a/b "), std::string::npos) << answer;
  EXPECT_NE(answer.find("Content-Security-Policy: default-src 'none'"), std::string::npos);
  EXPECT_NE(ask(server.port(), "POST /x", "", "body").find("POST /x body"), std::string::npos);
  EXPECT_NE(ask(server.port(), "GET /throw").find("500 Internal"), std::string::npos);
  const std::string head = ask(server.port(), "HEAD /a");
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
  EXPECT_EQ(server.counts().requests, 4U);
  EXPECT_EQ(server.url(), "http://localhost:" + std::to_string(server.port()) + "/");
}

TEST(WebServer, AnswersMayComeLaterAndLaterThanTheServer) {
  std::mutex mutex;
  std::vector<WebRespond> waiting;
  auto server = std::make_unique<WebServer>(anywhere(), [&](const WebRequest&, const WebRespond& respond) {
    const std::lock_guard<std::mutex> lock(mutex);
    waiting.push_back(respond);
  });
  const RawConnection first(server->port());
  const RawConnection second(server->port());
  // One after the other: requests of two connections may reach the handler in either order.
  for (const RawConnection* connection : {&first, &second}) {
    const std::size_t before = waiting.size();
    connection->send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_TRUE(soon([&] {
      const std::lock_guard<std::mutex> lock(mutex);
      return waiting.size() == before + 1;
    }));
  }
  waiting[0]({200, "text/plain", "late"});
  waiting[0]({200, "text/plain", "twice"});
  ASSERT_TRUE(soon([&] { return server->counts().requests == 2; }));
  const std::string answer = first.receive("late");
  EXPECT_NE(answer.find("late"), std::string::npos);
  server.reset();
  waiting[1]({200, "text/plain", "too late"});
  SUCCEED();
}

TEST(WebServer, ForeignersAreRefusedAndCounted) {
  const WebServer server(anywhere(), echo);
  EXPECT_NE(ask(server.port(), "GET /", "Host: evil.com\r\n").find("403"), std::string::npos);
  EXPECT_NE(ask(server.port(), "GET /", "Origin: http://evil.com\r\n").find("403"), std::string::npos);
  const RawConnection listener(server.port());
  listener.send(upgrade("/api/live", "Origin: http://evil.com\r\n"));
  EXPECT_NE(listener.receive("elf").find("403"), std::string::npos);
  EXPECT_EQ(server.counts().foreign, 3U);
  EXPECT_EQ(server.counts().requests, 0U);
}

TEST(WebServer, WhatIsNoRequestIsRefused) {
  const WebServer server(anywhere(), echo);
  EXPECT_NE(ask(server.port(), "GET /", "X: " + std::string(20'000, 'x') + "\r\n").find("413"),
            std::string::npos);
  EXPECT_NE(ask(server.port(), "POST /", "", std::string(100'000, 'x')).find("413"), std::string::npos);
  const RawConnection claims(server.port());
  claims.send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999\r\n\r\n");
  EXPECT_NE(claims.receive().find("413"), std::string::npos);
  const RawConnection nonsense(server.port());
  nonsense.send("\x16\x03\x01\x02\r\n\r\n");
  EXPECT_NE(nonsense.receive().find("400"), std::string::npos);
  EXPECT_EQ(server.counts().malformed, 4U);
  EXPECT_NE(ask(server.port(), "GET /still").find("/still"), std::string::npos);
}

TEST(WebServer, SurvivesMutatedRequests) {
  const WebServer server(anywhere(), echo);
  std::mt19937 generator(4);
  std::uniform_int_distribution<int> byte(0, 255);
  const std::vector<std::string> seeds = {
      "GET /api/page HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
      "POST /api/command HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: "
      "chunked\r\n\r\n5\r\nabcde\r\n0\r\n\r\n",
      upgrade() + "\x81\x85\x01\x02\x03\x04\x49\x67\x6f\x68\x6e"};
  for (int i = 0; i < 600; ++i) {
    std::string bytes = seeds[static_cast<std::size_t>(i) % seeds.size()];
    for (int changes = 1 + i % 4; changes > 0; --changes) {
      const std::size_t at = std::uniform_int_distribution<std::size_t>(0, bytes.size() - 1)(generator);
      if (i % 3 == 0) {
        bytes.erase(at, 3);
      } else {
        bytes[at] = static_cast<char>(byte(generator));
      }
      if (bytes.empty()) break;
    }
    const RawConnection connection(server.port());
    connection.send(bytes);
    connection.end();
    if (i % 50 == 0) connection.receive();
  }
  EXPECT_NE(ask(server.port(), "GET /still").find("/still"), std::string::npos);
}

TEST(WebServer, ListenersHearMessages) {
  WebServer server(anywhere(), echo);
  server.send_text("to nobody");
  const RawConnection listener(server.port());
  listener.send(upgrade());
  EXPECT_NE(listener.receive("\r\n\r\n").find("101 Switching"), std::string::npos);
  ASSERT_TRUE(soon([&] { return server.listeners() == 1; }));
  server.send_text("hello");
  EXPECT_EQ(listener.receive("hello"), "\x81\x05hello");
  server.send_binary(std::string("\0\1", 2));
  EXPECT_EQ(listener.receive(std::string("\0\1", 2)), std::string("\x82\x02\0\1", 4));
  const RawConnection elsewhere(server.port());
  elsewhere.send(upgrade("/api/other"));
  EXPECT_NE(elsewhere.receive("told").find("404"), std::string::npos);
}

TEST(WebServer, AListenerThatSendsTooMuchIsCutOff) {
  const WebServer server(anywhere(), echo);
  const RawConnection listener(server.port());
  listener.send(upgrade());
  listener.receive("\r\n\r\n");
  ASSERT_TRUE(soon([&] { return server.listeners() == 1; }));
  listener.send(std::string("\x82\xff\0\0\0\0\x10\0\0\0", 10) + std::string(4, 'm') +
                std::string(10'000, 'x'));
  listener.receive();
  EXPECT_TRUE(soon([&] { return server.listeners() == 0; }));
  EXPECT_EQ(server.counts().malformed, 1U);
}

TEST(WebServer, AListenerThatDoesNotReadIsCutOff) {
  WebServer server(anywhere(), echo);
  const RawConnection listener(server.port());
  listener.send(upgrade());
  listener.receive("\r\n\r\n");
  ASSERT_TRUE(soon([&] { return server.listeners() == 1; }));
  for (int i = 0; i < 100; ++i) server.send_binary(std::string(1 << 20, 'x'));
  EXPECT_TRUE(soon([&] { return server.listeners() == 0; }));
  EXPECT_EQ(server.counts().slow, 1U);
}

TEST(WebServer, BeyondTheMostConnectionsNobodyIsServed) {
  const WebServer server(anywhere(), echo);
  std::vector<std::unique_ptr<RawConnection>> idle;
  for (int i = 0; i < 70; ++i) idle.push_back(std::make_unique<RawConnection>(server.port()));
  EXPECT_TRUE(soon([&] { return server.counts().crowded == 6; })) << server.counts().crowded;
  idle.clear();
  EXPECT_TRUE(soon([&] { return ask(server.port(), "GET /again").find("/again") != std::string::npos; }));
}

TEST(WebServer, OthersNeedATokenAndGetTls) {
  WebOptions options = anywhere();
  options.address = "0.0.0.0";
  EXPECT_THROW(WebServer(options, echo), WebError);
  options.token = "secretsecretsecret";
  const WebServer server(options, echo);
  EXPECT_TRUE(server.url().starts_with("https://")) << server.url();
  EXPECT_TRUE(server.url().ends_with(":" + std::to_string(server.port()) + "/?token=secretsecretsecret"));
  EXPECT_EQ(server.fingerprint().size(), 95U) << server.fingerprint();
  const RawConnection plain(server.port());
  plain.send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(plain.receive().find("HTTP"), std::string::npos);
  EXPECT_TRUE(soon([&] { return server.counts().malformed == 1; }));
}

TEST(WebServer, AHundredWrongTokensShutTheDoor) {
  WebOptions options = anywhere();
  options.token = "secretsecretsecret";
  const WebServer server(options, echo);
  int shut = 0;
  for (int i = 0; i < 100; ++i) {
    const std::string answer = ask(server.port(), "GET /", "Authorization: Bearer wrong\r\n");
    EXPECT_TRUE(answer.find("401") != std::string::npos || answer.find("429") != std::string::npos) << answer;
    shut += answer.find("429") != std::string::npos;
  }
  EXPECT_EQ(shut, 90);
  EXPECT_EQ(server.counts().denied, 100U);
}

TEST(WebServer, ATokenInTheAddressBecomesACookie) {
  WebOptions options = anywhere();
  options.token = "secretsecretsecret";
  const WebServer server(options, echo);
  const std::string answer = ask(server.port(), "GET /?token=secretsecretsecret");
  EXPECT_NE(answer.find("303"), std::string::npos) << answer;
  EXPECT_NE(answer.find("Location: /\r\n"), std::string::npos);
  EXPECT_NE(answer.find("Set-Cookie: evermap=secretsecretsecret"), std::string::npos);
  EXPECT_NE(ask(server.port(), "GET /in", "Cookie: evermap=secretsecretsecret\r\n").find("GET /in"),
            std::string::npos);
}

TEST(WebServer, SaysWhyItCannotServe) {
  const WebServer first(anywhere(), echo);
  WebOptions options = anywhere();
  options.port = first.port();
  try {
    const WebServer second(options, echo);
    FAIL();
  } catch (const WebError& error) {
    EXPECT_NE(std::string(error.what()).find("another program is there"), std::string::npos) << error.what();
  }
  options.address = "nowhere";
  EXPECT_THROW(WebServer(options, echo), WebError);
  options = anywhere();
  options.address = "0.0.0.0";
  options.token = "secretsecretsecret";
  options.certificate = "/nonexistent.pem";
  EXPECT_THROW(WebServer(options, echo), WebError);
}

}  // namespace
}  // namespace evermap
