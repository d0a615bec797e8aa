// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Real recordings, where they are at hand.
#include "bags/bag_writer.hpp"
#include <evermap/bags/detail/bag_summary.hpp>
#include <evermap/bags/scan_bag.hpp>

namespace evermap {
namespace {

std::filesystem::path data_folder() {
  const char* folder = std::getenv("EVERMAP_DATA");
  return folder != nullptr ? folder : EVERMAP_DEFAULT_DATA;
}

struct Recording {
  const char* file;
  const char* topic;  ///< of the clouds
  std::size_t clouds;
  std::size_t points;  ///< of all clouds, used or dropped
};

TEST(RecordedBags, CloudsAreRead) {
  if (!std::filesystem::exists(data_folder())) GTEST_SKIP() << "no data at " << data_folder();
  for (const Recording& recording : {Recording{"ouster_os1/mcap_os1_64/test.mcap", "", 2, 262144}}) {
    SCOPED_TRACE(recording.file);
    const auto scans = open_scans(data_folder() / recording.file, {.topic = recording.topic});
    EXPECT_EQ(scans->size(), recording.clouds);
    std::size_t points = 0;
    std::size_t clouds = 0;
    while (const std::optional<Scan> scan = scans->next()) {
      ++clouds;
      points += scan->p_sensor.size() + scan->dropped_at_origin + scan->dropped_not_finite;
    }
    EXPECT_EQ(clouds, recording.clouds);
    EXPECT_EQ(points, recording.points);
    EXPECT_TRUE(scans->remarks().empty());
  }
}

TEST(RecordedBags, ACloudAsAMiddlewareSentItIsRead) {
  const std::filesystem::path file = data_folder() / "reader_fixtures/cdr_and_pcd/cloudini_dds_message.bin";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const BagTopic topic{"/points", "sensor_msgs/PointCloud2", Wire::kCdr};
  const CloudMessage cloud = read_cloud_message(topic, bytes, file);
  const Scan& scan = cloud.scan;
  EXPECT_EQ(scan.p_sensor.size() + scan.dropped_at_origin + scan.dropped_not_finite, 64000U);
  EXPECT_FALSE(cloud.frame.empty());
}

TEST(RecordedBags, EveryOneIsSummarized) {
  const std::filesystem::path fixtures = data_folder() / "reader_fixtures";
  if (!std::filesystem::exists(fixtures)) GTEST_SKIP() << "no data at " << fixtures;
  std::size_t bags = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(fixtures)) {
    if (!entry.is_regular_file() || !is_bag(entry.path())) continue;
    SCOPED_TRACE(entry.path());
    const BagSummary summary = summarize_bag(entry.path());
    EXPECT_EQ(summary.damage, "");
    for (const TopicSummary& topic : summary.topics)
      EXPECT_EQ(topic.messages, topic.topic.messages) << topic.topic.name;
    ++bags;
  }
  EXPECT_GT(bags, 8U);
}

}  // namespace
}  // namespace evermap
