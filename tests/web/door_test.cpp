// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/web/detail/door.hpp>
#include <evermap/web/web_server.hpp>

namespace evermap {
namespace {

using Verdict = Door::Verdict;

Door::Visitor local(const std::string& host, const std::string& origin = "") {
  return {"127.0.0.1", host, origin, "", "", ""};
}

TEST(Door, WithoutATokenOnlyTheMachinesOwnNamesAreAnswered) {
  Door door("");
  for (const char* host : {"localhost:7447", "localhost", "127.0.0.1:7447", "127.0.0.1:80", "[::1]:7447"})
    EXPECT_EQ(door.judge(local(host), 0), Verdict::kWelcome) << host;
  // A name of an attacker's that leads here, too.
  for (const char* host : {"evil.com:7447", "localhost.evil.com", "128.0.0.1:7447", "", "[", "]", ":"})
    EXPECT_EQ(door.judge(local(host), 0), Verdict::kForeign) << host;
}

TEST(Door, PagesOfOtherSitesAreRefused) {
  Door open("");
  EXPECT_EQ(open.judge(local("localhost:7447", "http://localhost:7447"), 0), Verdict::kWelcome);
  for (const char* origin :
       {"http://evil.com", "http://localhost:8080", "https://localhost", "null", "://", "localhost:7447"})
    EXPECT_EQ(open.judge(local("localhost:7447", origin), 0), Verdict::kForeign) << origin;
  Door door("secretsecretsecret");
  Door::Visitor visitor = local("robot:7447", "https://evil.com");
  visitor.cookie = "evermap=secretsecretsecret";
  EXPECT_EQ(door.judge(visitor, 0), Verdict::kForeign);
  visitor.origin = "https://robot:7447";
  EXPECT_EQ(door.judge(visitor, 0), Verdict::kWelcome);
}

TEST(Door, ATokenMayComeInThreeWays) {
  Door door("secretsecretsecret");
  EXPECT_EQ(door.judge({"9.9.9.9", "robot", "", "", "", ""}, 0), Verdict::kUnknown);
  EXPECT_EQ(door.judge({"9.9.9.9", "robot", "", "Bearer secretsecretsecret", "", ""}, 0), Verdict::kWelcome);
  EXPECT_EQ(door.judge({"9.9.9.9", "robot", "", "", "a=b; evermap=secretsecretsecret", ""}, 0),
            Verdict::kWelcome);
  EXPECT_EQ(door.judge({"9.9.9.9", "robot", "", "", "", "x=1&token=secretsecretsecret"}, 0),
            Verdict::kNewcomer);
  for (const char* wrong : {"Bearer ", "Bearer secretsecretsecreT", "Bearer secret", "secretsecretsecret"})
    EXPECT_EQ(door.judge({"9.9.9.9", "robot", "", wrong, "", ""}, 0), Verdict::kUnknown) << wrong;
  EXPECT_NE(door.cookie().find("HttpOnly; SameSite=Strict; Secure"), std::string::npos);
}

TEST(Door, IsShutForAMinuteAfterTenWrongTokens) {
  Door door("secretsecretsecret");
  const auto show = [&](const std::string& address, const std::string& token, double now) {
    return door.judge({address, "robot", "", "Bearer " + token, "", ""}, now);
  };
  for (int i = 0; i < 10; ++i) EXPECT_EQ(show("9.9.9.9", "wrong", i), Verdict::kUnknown);
  for (int i = 10; i < 59; ++i) {
    EXPECT_EQ(show("9.9.9.9", "wrong", i), Verdict::kShut);
    EXPECT_EQ(show("9.9.9.9", "secretsecretsecret", i), Verdict::kShut);
  }
  EXPECT_EQ(show("8.8.8.8", "secretsecretsecret", 20), Verdict::kWelcome);
  EXPECT_EQ(show("9.9.9.9", "secretsecretsecret", 61), Verdict::kWelcome);
}

TEST(Door, MadeTokensDiffer) {
  const std::string token = make_token();
  EXPECT_EQ(token.size(), 24U);
  EXPECT_EQ(token.find_first_not_of(kTokenLetters), std::string::npos);
  EXPECT_NE(token, make_token());
}

}  // namespace
}  // namespace evermap
