// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <thread>

#include "app/program.hpp"

namespace evermap {
namespace {

class ServeTest : public ProgramTest {
 protected:
  ServeTest() {
    make_hall_drive("drive", 30);
    expect_done(build("drive", "map.evm"));
  }

  /// Too slow to follow ten clouds a second.
  static bool is_sanitized() {
#ifdef __has_feature
    return __has_feature(address_sanitizer);
#else
    return false;
#endif
  }

  std::vector<std::string> with_domain(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--local", "--domain", std::to_string(1 + ::getpid() % 100)});
    return arguments;
  }
  /// A robot's map keeper that has begun; its output is apart from that of what is run beside it.
  std::unique_ptr<Process> serve() const {
    std::filesystem::remove(path("serve.out"));
    auto process = std::make_unique<Process>(with_domain({"serve", name("map.evm")}), path("serve.out"),
                                             path("serve.err"));
    while (!std::filesystem::exists(path("serve.out")) || content(path("serve.out")).empty())
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return process;
  }
  Result play() const { return run(with_domain({"play", name("drive"), "--odometry", name("drive.txt")})); }
};

TEST_F(ServeTest, AnswersACloudOnTheTransforms) {
  if (is_sanitized()) GTEST_SKIP() << "not in real time";
  const std::unique_ptr<Process> server = serve();
  const Result played = play();
  EXPECT_EQ(played.exit_code, 0) << played.err;
  EXPECT_NE(played.out.find("played   30 clouds"), std::string::npos) << played.out;
  EXPECT_NE(played.out.find(" on /tf, half of them within"), std::string::npos) << played.out;
  server->send(SIGTERM);
  EXPECT_EQ(server->wait(), 128 + SIGTERM);
  EXPECT_NE(content(path("serve.out")).find("0 damaged"), std::string::npos);
  const Result log = run({"log", name("map.evm")});
  EXPECT_NE(log.out.find("serve, "), std::string::npos) << log.out;
}

TEST_F(ServeTest, WhatItAcknowledgedComesBackWhenItIsKilled) {
  if (is_sanitized()) GTEST_SKIP() << "not in real time";
  std::unique_ptr<Process> server = serve();
  EXPECT_EQ(play().exit_code, 0);
  server->send(SIGKILL);
  EXPECT_EQ(server->wait(), -SIGKILL);
  server = serve();
  server->send(SIGINT);
  EXPECT_EQ(server->wait(), 128 + SIGINT);
  EXPECT_NE(content(path("serve.err")).find("the run before was ended by force"), std::string::npos)
      << content(path("serve.err"));
}

TEST_F(ServeTest, ASecondOneIsRefused) {
  const std::unique_ptr<Process> server = serve();
  const Result second = run(with_domain({"serve", name("map.evm")}));
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_NE(second.err.find("process"), std::string::npos) << second.err;
}

TEST_F(ServeTest, PlayingToNobodyIsAnError) {
  expect_failed(with_domain({"play", name("drive"), "--wait", "0.2"}), "nobody listened to the clouds");
}

}  // namespace
}  // namespace evermap
