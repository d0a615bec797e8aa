// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <thread>

#include "app/program.hpp"
#include "web/http_client.hpp"

namespace evermap {
namespace {

class ViewTest : public ProgramTest {
 protected:
  ViewTest() {
    make_drive("before", 5, true);
    make_drive("now", 12, false);
    expect_done(build("before", "map.evm"));
    expect_done(update("map.evm", "now", "map.evm", {"--report", name("report")}));
  }

  /// Of the page that a running program has said where it is.
  std::uint16_t port(const std::string& out) const {
    for (int i = 0; i < 2000; ++i) {
      const std::string said = content(path(out));
      const std::size_t at = said.find("localhost:");
      if (at != std::string::npos && said.find('/', at) != std::string::npos)
        return static_cast<std::uint16_t>(std::stoi(said.substr(at + 10)));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "no page: " << content(path(out)) << content(path("stderr"));
    return 0;
  }
};

TEST_F(ViewTest, ServesTheMapUntilItIsStopped) {
  const std::unique_ptr<Process> view = start({"view", name("map.evm"), "1..now", "--port", "0"});
  const std::uint16_t at = port("stdout");
  EXPECT_NE(ask(at, "GET /").find("<title>evermap</title>"), std::string::npos);
  const std::string page = ask(at, "GET /api/page");
  EXPECT_NE(page.find("\"shown\":\"1..now\""), std::string::npos) << page;
  EXPECT_NE(page.find("\"number\":2"), std::string::npos) << page;
  EXPECT_NE(ask(at, "GET /api/maps/1..now/changes").find("\"has_come\":false"), std::string::npos);
  view->send(SIGINT);
  EXPECT_EQ(view->wait(), 128 + SIGINT);
}

TEST_F(ViewTest, TakesVersionsByTheirTags) {
  expect_done({"tag", name("map.evm"), "before", "1"});
  const std::unique_ptr<Process> view = start({"view", name("map.evm"), "before..now", "--port", "0"});
  EXPECT_NE(ask(port("stdout"), "GET /api/page").find("\"shown\":\"1..now\""), std::string::npos);
}

TEST_F(ViewTest, ServesAReport) {
  const std::unique_ptr<Process> view = start({"view", name("map.evm"), name("report"), "--port", "0"});
  EXPECT_NE(ask(port("stdout"), "GET /").find("id=\"map-data\""), std::string::npos);
}

TEST_F(ViewTest, SaysWhatItCannotShow) {
  expect_failed({"view", name("none.evm"), "--port", "0"}, "none.evm");
  expect_failed({"view", name("map.evm"), "7", "--port", "0"}, "holds no version \"7\"");
  expect_failed({"view", name("map.evm"), "nonsense", "--port", "0"}, "holds no version \"nonsense\"");
  expect_failed({"view", name("map.evm"), name("now"), "--port", "0"}, "viewer.html");
  expect_failed({"view", name("map.evm"), "--listen", "nowhere", "--port", "0"}, "is no address");
  expect_failed({"view", name("map.evm"), "--token-file", name("none"), "--port", "0"},
                "no token can be read");
  make("short", "abc\n");
  expect_failed({"view", name("map.evm"), "--token-file", name("short"), "--port", "0"},
                "at least 16 letters");
  make("no.pem", "nonsense");
  expect_failed({"view", name("map.evm"), "--listen", "0.0.0.0", "--certificate", name("no.pem"), "--key",
                 name("no.pem"), "--port", "0"},
                "is no certificate");
}

TEST_F(ViewTest, APortInUseIsNamed) {
  const std::unique_ptr<Process> view = std::make_unique<Process>(
      std::vector<std::string>{"view", name("map.evm"), "--port", "0"}, path("view.out"), path("view.err"));
  const std::string at = std::to_string(port("view.out"));
  expect_failed({"view", name("map.evm"), "--port", at}, "another program is there");
}

TEST_F(ViewTest, OthersGetTheirPageOverTls) {
  const std::unique_ptr<Process> view =
      start({"view", name("map.evm"), "--listen", "0.0.0.0", "--port", "0"});
  for (int i = 0; i < 2000 && content(path("stdout")).find("SHA-256") == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const std::string said = content(path("stdout"));
  EXPECT_NE(said.find("page     https://"), std::string::npos) << said;
  EXPECT_NE(said.find("/?token="), std::string::npos) << said;
}

TEST_F(ViewTest, ARobotsPageTakesCommands) {
  const std::unique_ptr<Process> serve = start(
      {"serve", name("map.evm"), "--local", "--domain", std::to_string(1 + ::getpid() % 100), "--port", "0"});
  const std::uint16_t at = port("stdout");
  EXPECT_NE(ask(at, "GET /api/page").find("\"live\":true"), std::string::npos);
  const std::string reply = ask(at, "POST /api/command", "", "{\"command\":\"save\"}");
  EXPECT_NE(reply.find("{\"reply\":\"save: done\"}"), std::string::npos) << reply;
  EXPECT_NE(ask(at, "POST /api/command", "", "{\"command\":\"dance\"}").find("dance: unknown"),
            std::string::npos);
  const std::string status = ask(at, "GET /api/status");
  EXPECT_NE(status.find("no cloud comes on /points"), std::string::npos) << status;
  EXPECT_NE(ask(at, "POST /api/command", "Origin: http://evil.com\r\n", "{\"command\":\"save\"}").find("403"),
            std::string::npos);
}

}  // namespace
}  // namespace evermap
