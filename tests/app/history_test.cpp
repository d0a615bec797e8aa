// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <nlohmann/json.hpp>

#include "app/program.hpp"

namespace evermap {
namespace {

using Json = nlohmann::json;

/// A map of a room with a wall, and its version without.
class HistoryTest : public ProgramTest {
 protected:
  HistoryTest() {
    make_drive("before", 5, true);
    make_drive("now", 12, false);
    expect_done(build("before", "map.evm"));
    first_ = content(path("map.evm"));
    expect_done(update("map.evm", "now", "map.evm"));
    second_ = content(path("map.evm"));
  }
  Json json(const std::vector<std::string>& arguments) const {
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(result.out);
  }
  Json versions() const { return json({"log", name("map.evm"), "--json"})["versions"]; }

  std::string first_;
  std::string second_;
};

TEST_F(HistoryTest, LogTellsWhatWhenAndHow) {
  const Json all = versions();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0]["cause"], "as it was found");
  EXPECT_EQ(all[1]["cause"], "update " + name("now") + ", 12 scans");
  EXPECT_EQ(all[1]["parameters"].get<std::string>().size(), 16U);
  EXPECT_EQ(all[1]["evermap"], EVERMAP_VERSION);
  EXPECT_NE(run({"log", name("map.evm")}).out.find("as it was found"), std::string::npos);
  make("new.evm", first_);
  expect_failed({"log", name("new.evm")}, "has no history");
}

TEST_F(HistoryTest, VersionsAreReadByNumberAndByTag) {
  expect_done({"tag", name("map.evm"), "with-wall", "1"});
  for (const char* version : {"1", "with-wall"}) {
    expect_done({"checkout", name("map.evm") + "@" + version, "-o", name("old.evm")});
    EXPECT_TRUE(content(path("old.evm")) == first_) << version;
  }
  EXPECT_EQ(json({"info", name("map.evm@1"), "--json"})["leaves"],
            json({"info", name("old.evm"), "--json"})["leaves"]);
  expect_done({"export", name("map.evm@1"), name("old.pcd")});
  expect_failed({"info", name("map.evm@7")}, "holds no version \"7\"; there are 1 to 2");
  expect_failed({"info", name("none.evm@7")}, "has no history");
}

TEST_F(HistoryTest, OfManyWritersAtOnceNoneIsLostAndReadersSeeWholeMaps) {
  constexpr int kWriters = 4;
  std::vector<std::string> arguments = update("map.evm", "now", "map.evm");
  arguments.insert(arguments.end(), {"--wait", "120"});
  std::vector<std::unique_ptr<Process>> writers;
  for (int i = 0; i < kWriters; ++i) {
    const std::string number = std::to_string(i);
    writers.push_back(std::make_unique<Process>(arguments, path("out" + number), path("err" + number)));
  }
  std::size_t all = 2;
  for (int look = 0; all < 2 + kWriters; ++look) {
    ASSERT_LT(look, 10'000) << "a writer ended without its version";
    expect_done({"info", name("map.evm")});
    const std::size_t now = versions().size();
    ASSERT_GE(now, all);
    if (now > all) expect_done({"info", name("map.evm@" + std::to_string(now))});
    all = now;
  }
  for (int i = 0; i < kWriters; ++i)
    EXPECT_EQ(writers[i]->wait(), 0) << content(path("err" + std::to_string(i)));
  EXPECT_EQ(versions().size(), 2U + kWriters);
  expect_done({"verify", name("map.evm")});
}

TEST_F(HistoryTest, DiffTellsWhatWent) {
  const Json change = json({"diff", name("map.evm@1"), name("map.evm"), "--json", "--report", name("report"),
                            "--pcd", name("diff.pcd")});
  EXPECT_GT(change["leaves"]["removed"], 20);
  EXPECT_TRUE(std::filesystem::exists(path("report/change.png")));
  EXPECT_NE(content(path("diff.pcd")).find("FIELDS x y z change"), std::string::npos);
  const Json none = json({"diff", name("map.evm@2"), name("map.evm"), "--json"});
  EXPECT_EQ(none["leaves"]["removed"], 0);
  EXPECT_EQ(none["leaves"]["added"], 0);
}

TEST_F(HistoryTest, UndoIsAVersion) {
  expect_done({"undo", name("map.evm")});
  EXPECT_TRUE(content(path("map.evm")) == first_);
  expect_done({"undo", name("map.evm")});
  EXPECT_TRUE(content(path("map.evm")) == second_);
  EXPECT_EQ(versions().size(), 4U);
  expect_done({"prune", name("map.evm"), "--keep", "0h", "--keep-daily", "0h"});
  EXPECT_EQ(versions().size(), 1U);
  EXPECT_EQ(run({"prune", name("map.evm"), "--keep", "soon"}).exit_code, 2);
}

TEST_F(HistoryTest, DamageIsNamedAndRepaired) {
  expect_done({"verify", name("map.evm")});
  std::string damaged = second_;
  damaged[damaged.size() / 2] ^= 1;
  make("map.evm", damaged);
  const Result found = run({"verify", name("map.evm")});
  EXPECT_EQ(found.exit_code, 1);
  EXPECT_NE(found.out.find("versions 2 of 2 sound"), std::string::npos) << found.out;
  expect_done({"repair", name("map.evm")});
  EXPECT_TRUE(content(path("map.evm")) == second_);
  expect_done({"verify", name("map.evm")});
}

}  // namespace
}  // namespace evermap
