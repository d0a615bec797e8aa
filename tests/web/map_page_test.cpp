// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>
#include <support/random_octree.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "files/file_fixture.hpp"
#include <evermap/history/map_store.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/web/detail/map_tiles.hpp>
#include <evermap/web/detail/page.hpp>
#include <evermap/web/live_page.hpp>
#include <evermap/web/map_page.hpp>

namespace evermap {
namespace {

using Json = nlohmann::json;

class MapPageTest : public FileTest {
 protected:
  MapPageTest() {
    std::mt19937 generator(5);
    first_ = random_octree(generator, 2000, first_.grid());
    second_ = first_;
    first_.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
      if (leaf.occupied() && key.voxel().x() > 0) second_.erase(key);
    });
    save_map(map(), first_);
    MapStore store(map());
    store.commit(second_, {"change", ""});
  }

  std::filesystem::path map() const { return path("map.evm"); }

  static WebReply ask(MapPage& page, const std::string& target, const std::string& method = "GET",
                      const std::string& body = "") {
    std::optional<WebReply> reply;
    page.respond({method, target, body}, [&](WebReply given) { reply = std::move(given); });
    EXPECT_TRUE(reply.has_value()) << target;
    return reply.value_or(WebReply{});
  }
  static std::size_t leaves_of(MapPage& page, const std::string& name) {
    const std::string bytes = ask(page, "/api/maps/" + name + "/blocks").body;
    std::vector<TileBlock> blocks(bytes.size() / sizeof(TileBlock));
    std::memcpy(blocks.data(), bytes.data(), bytes.size());
    std::size_t points = 0;
    for (const TileBlock& block : blocks) {
      const std::string target = "/api/maps/" + name + "/tiles/0/" + std::to_string(block.at[0]) + "/" +
                                 std::to_string(block.at[1]) + "/" + std::to_string(block.at[2]);
      points += ask(page, target).body.size() / sizeof(TilePoint);
    }
    return points;
  }
  static std::size_t occupied(const Octree& octree) {
    std::size_t count = 0;
    octree.for_each_leaf([&](VoxelKey, const Leaf& leaf) { count += leaf.occupied(); });
    return count;
  }

  Octree first_{VoxelGrid{0.2, Eigen::Vector3d::Zero()}};
  Octree second_ = first_;
};

TEST_F(MapPageTest, HasAllVersionsAndTheirDifferences) {
  MapPage page(map());
  const Json described = Json::parse(ask(page, "/api/page").body);
  EXPECT_EQ(described["name"], "map.evm");
  EXPECT_EQ(described["live"], false);
  EXPECT_EQ(described["edge"], 0.2);
  ASSERT_EQ(described["versions"].size(), 2U);
  EXPECT_EQ(described["versions"][1]["what"], "change");
  EXPECT_EQ(leaves_of(page, "now"), occupied(second_));
  EXPECT_EQ(leaves_of(page, "1"), occupied(first_));
  EXPECT_EQ(leaves_of(page, "2"), occupied(second_));
  const std::size_t gone = compare(first_, second_).removed.size();
  EXPECT_GT(gone, 0U);
  EXPECT_EQ(leaves_of(page, "1..2"), occupied(second_) + gone);
  EXPECT_EQ(leaves_of(page, "1..now"), occupied(second_) + gone);
  const Json changes = Json::parse(ask(page, "/api/maps/1..now/changes").body);
  EXPECT_EQ(changes.size(), surface_changes(first_, second_).size());
}

TEST_F(MapPageTest, WhatIsNotThereIsNotFound) {
  MapPage page(map());
  for (const char* path :
       {"/x", "/api", "/api/maps", "/api/maps/now", "/api/maps/3/blocks", "/api/maps/x/blocks",
        "/api/maps/-1/blocks", "/api/maps/1..9/blocks", "/api/maps/1..2..3/blocks", "/api/maps/../blocks",
        "/api/maps/now/changes", "/api/maps/now/tiles/0/0/0", "/api/maps/now/tiles/16/0/0/0",
        "/api/maps/now/tiles/-1/0/0/0", "/api/maps/now/tiles/0/0/0/99999999999",
        "/api/maps/now/tiles/0/0/0/x", "/api/maps/now/nonsense"}) {
    EXPECT_EQ(ask(page, path).status, 404U) << path;
  }
  EXPECT_EQ(ask(page, "/", "PUT").status, 405U);
  EXPECT_EQ(ask(page, "/api/command", "POST", "{\"command\":\"save\"}").status, 404U);
  EXPECT_EQ(ask(page, "/api/command", "POST", "{").status, 400U);
  EXPECT_EQ(ask(page, "/api/command", "POST", "[1]").status, 400U);
  EXPECT_EQ(ask(page, "/api/command", "POST", "{\"command\":7}").status, 400U);
  EXPECT_THROW(MapPage(path("none.evm")), FileError);
  EXPECT_THROW(MapPage(map(), "7..8"), FileError);
  EXPECT_THROW(MapPage(map(), "nonsense"), FileError);
}

TEST_F(MapPageTest, LeavesKnowSinceWhenTheyAreThere) {
  Octree third = second_;
  const VoxelKey fresh = VoxelKey::from_voxel({1, 2, 3});
  Leaf& leaf = third.find_or_insert(fresh);
  leaf.count = 5;
  leaf.log_odds = 2;
  MapStore(map()).commit(third, {"another", ""});
  MapPage page(map());
  const std::string bytes = ask(page, "/api/maps/now/tiles/0/0/0/0").body;
  std::vector<TilePoint> points(bytes.size() / sizeof(TilePoint));
  std::memcpy(points.data(), bytes.data(), bytes.size());
  std::size_t of_third = 0;
  for (const TilePoint& point : points) {
    of_third += point.age.since == 3;
    EXPECT_TRUE(point.age.since == 0 || point.age.since == 3);
  }
  EXPECT_EQ(of_third, 1U);
}

TEST_F(MapPageTest, AMapThatAnotherProcessPutInPlaceIsShown) {
  MapPage page(map());
  const std::string changed = Json::parse(ask(page, "/api/page").body)["changed"].dump();
  EXPECT_EQ(leaves_of(page, "now"), occupied(second_));
  Octree third = second_;
  Leaf& leaf = third.find_or_insert(VoxelKey::from_voxel({1, 2, 3}));
  leaf.count = 5;
  leaf.log_odds = 2;
  MapStore(map()).commit(third, {"another", ""});
  EXPECT_EQ(leaves_of(page, "now"), occupied(third));
  EXPECT_NE(Json::parse(ask(page, "/api/page").body)["changed"].dump(), changed);
}

TEST_F(MapPageTest, ALiveMapTellsWhatChanges) {
  MapPage page(map(), first_);
  EXPECT_EQ(Json::parse(ask(page, "/api/page").body)["live"], true);
  EXPECT_EQ(page.show(first_), "");
  const Json changed = Json::parse(page.show(second_));
  EXPECT_GT(changed["blocks"].size(), 0U);
  EXPECT_EQ(leaves_of(page, "now"), occupied(second_) + compare(first_, second_).removed.size());
  EXPECT_EQ(leaves_of(page, "1..now"), leaves_of(page, "now"));
  page.set_commands([](const std::string& command, const std::function<void(std::string)>& reply) {
    reply(command + ": done");
  });
  EXPECT_EQ(Json::parse(ask(page, "/api/command", "POST", "{\"command\":\"save\"}").body)["reply"],
            "save: done");
  EXPECT_EQ(ask(page, "/api/status").body, "{}");
  page.set_status("{\"state\":\"tracking\"}");
  EXPECT_EQ(ask(page, "/api/status").body, "{\"state\":\"tracking\"}");
}

TEST_F(MapPageTest, ThePageLoadsNothingFromElsewhere) {
  const std::string html(page());
  EXPECT_GT(html.size(), 100'000U);
  EXPECT_NE(html.find("<!--map-->"), std::string::npos);
  EXPECT_EQ(html.find("<script src"), std::string::npos);
  EXPECT_EQ(html.find("<link rel=\"stylesheet"), std::string::npos);
  EXPECT_EQ(html.find("@import"), std::string::npos);
}

TEST_F(MapPageTest, AMapInThePageCannotEndItsScript) {
  const std::string html = page_with_map(second_, first_, "</script><b>.evm");
  const std::size_t begin = html.find("id=\"map-data\">");
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = html.find("</script>", begin);
  const Json data = Json::parse(html.substr(begin + 14, end - begin - 14));
  EXPECT_EQ(data["name"], "</script><b>.evm");
  EXPECT_EQ(data["level"], 0);
  EXPECT_EQ(data["changes"].size(), surface_changes(first_, second_).size());
  EXPECT_LT(html.size(), page().size() + 40 * first_.leaf_count());
}

}  // namespace
}  // namespace evermap
