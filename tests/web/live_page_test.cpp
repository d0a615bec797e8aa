// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <random>
#include <support/random_octree.hpp>
#include <thread>

#include <gtest/gtest.h>

#include "web/http_client.hpp"
#include <evermap/web/live_page.hpp>

namespace evermap {
namespace {

TEST(LivePage, ThreadsAskWhileTheMapChanges) {
  std::mt19937 generator(6);
  Octree map = random_octree(generator, 2000, VoxelGrid{0.2, Eigen::Vector3d::Zero()});
  const Octree begun = map;
  std::vector<VoxelKey> keys;
  map.for_each_leaf([&](VoxelKey key, const Leaf&) { keys.push_back(key); });
  WebOptions options;
  options.port = 0;
  LivePage page(
      "none.evm", begun, options,
      [](const std::string& command, const std::function<void(std::string)>& reply) { reply(command); });
  std::atomic<bool> is_over = false;
  std::atomic<int> answers = 0;
  std::vector<std::thread> browsers;
  for (const std::string path :
       {"/api/maps/now/tiles/2/0/0/0", "/api/maps/now/blocks", "/api/status", "/api/maps/now/changes"}) {
    browsers.emplace_back([&, path] {
      while (!is_over)
        answers += ask(page.server().port(), "GET " + path).find("200 OK") != std::string::npos;
    });
  }
  const RawConnection listener(page.server().port());
  listener.send(upgrade());
  listener.receive("\r\n\r\n");
  const std::vector<Eigen::Vector3d> scan(100, Eigen::Vector3d(1, 2, 3));
  for (std::size_t i = 0; i < 200 || answers < 40; ++i) {
    map.erase(keys[i % keys.size()]);
    page.tell({0, "tracking", 0, "", true, Pose{}, {}});
    page.show_scan(scan, Pose{});
    if (page.is_ready()) page.show(map);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  is_over = true;
  for (std::thread& browser : browsers) browser.join();
  EXPECT_NE(listener.receive("\"blocks\"").find("\"status\":{"), std::string::npos);
  EXPECT_GE(answers, 40);
}

}  // namespace
}  // namespace evermap
