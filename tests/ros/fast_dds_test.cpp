// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// The other vendor: most robots' ROS speaks Fast DDS. Its messages are made here by Fast CDR, whose code has
// nothing in common with idlc's or ours.
#include <array>
#include <chrono>
#include <cstring>
#include <fastcdr/Cdr.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <functional>
#include <memory>
#include <mutex>
#include <ros_messages.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include <gtest/gtest.h>

#include <evermap/bags/detail/messages.hpp>
#include <evermap/ros/detail/dds.hpp>
#include <evermap/ros/detail/map_topics.hpp>

namespace evermap {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using std::chrono::milliseconds;

unsigned other_domain() { return 101 + static_cast<unsigned>(::getpid()) % 90; }

/// A type that is only a name: its messages are bytes.
class NamedType : public fast::TopicDataType {
 public:
  explicit NamedType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 4 << 20;
    m_isGetKeyDefined = false;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<std::string*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<std::string*>(data)->assign(reinterpret_cast<char*>(payload->data), payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<std::string*>(data)->size()); };
  }
  void* createData() override { return new std::string; }
  void deleteData(void* data) override { delete static_cast<std::string*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

/// A participant of the other vendor, on loopback without multicast as ours is.
class FastNode {
 public:
  FastNode() {
    fast::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList = {"127.0.0.1"};
    udp->receiveBufferSize = udp->sendBufferSize = 4 << 20;
    qos.transport().user_transports.push_back(udp);
    for (std::uint32_t participant = 0; participant < 10; ++participant) {
      rtps::Locator_t peer;
      eprosima::fastrtps::rtps::IPLocator::setIPv4(peer, 127, 0, 0, 1);
      peer.port = 7400 + 250 * other_domain() + 10 + 2 * participant;
      qos.wire_protocol().builtin.initialPeersList.push_back(peer);
    }
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(other_domain(), qos);
  }
  ~FastNode() {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  FastNode(const FastNode&) = delete;
  FastNode& operator=(const FastNode&) = delete;

  fast::Topic* topic(const std::string& name, const std::string& type) {
    fast::TypeSupport(new NamedType(type)).register_type(participant_);
    return participant_->create_topic("rt" + name, type, fast::TOPIC_QOS_DEFAULT);
  }
  fast::DataWriter* writer(const std::string& name, const std::string& type) {
    fast::DataWriterQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.publish_mode().kind = fast::ASYNCHRONOUS_PUBLISH_MODE;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
        ->create_datawriter(topic(name, type), qos);
  }
  fast::DataReader* reader(const std::string& name, const std::string& type) {
    fast::DataReaderQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
        ->create_datareader(topic(name, type), qos);
  }

 private:
  fast::DomainParticipant* participant_;
};

/// A cloud of 130,000 points as ROS's Fast DDS sends it: 2 MB, in many pieces.
std::string cloud_by_fast_cdr(std::uint32_t points) {
  std::string memory(points * 16 + 1000, '\0');
  FastBuffer buffer(memory.data(), memory.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  cdr << std::int32_t{1700000000} << std::uint32_t{500000000} << std::string("lidar");
  cdr << std::uint32_t{1} << points;
  cdr << std::uint32_t{4};
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z", "intensity"}) {
    cdr << std::string(name) << offset << std::uint8_t{7} << std::uint32_t{1};
    offset += 4;
  }
  cdr << false << std::uint32_t{16} << points * 16;
  cdr << points * 16;
  std::vector<float> values(std::size_t{points} * 4);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 1000) + 1;
  cdr.serializeArray(reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(float));
  cdr << true;
  memory.resize(cdr.getSerializedDataLength() + 4);
  return memory;
}

TEST(FastDds, IsHeard) {
  DdsNode node(other_domain(), true);
  DdsReader reader(node, "/points", sensor_msgs_msg_dds__PointCloud2__desc, Delivery::kSensorData, 4);
  FastNode other;
  fast::DataWriter* writer = other.writer("/points", "sensor_msgs::msg::dds_::PointCloud2_");
  constexpr std::uint32_t kPoints = 130000;
  std::string sent = cloud_by_fast_cdr(kPoints);
  for (int i = 0; i < 100; ++i) {
    writer->write(&sent);
    node.wait(0.1);
    for (const DdsMessage& message : reader.take()) {
      EXPECT_TRUE(message.bytes == sent) << "not the same bytes";
      const CloudMessage cloud =
          read_cloud_message({"/points", "sensor_msgs/PointCloud2", Wire::kCdr}, message.bytes, "/points");
      EXPECT_EQ(cloud.frame, "lidar");
      EXPECT_EQ(cloud.scan.p_sensor.size(), kPoints);
      EXPECT_DOUBLE_EQ(*cloud.scan.time, 1700000000.5);
      EXPECT_EQ(cloud.scan.p_sensor[1], Eigen::Vector3d(5, 6, 7));
      return;
    }
  }
  FAIL() << "nothing came";
}

/// What the other vendor received on a topic; empty after ten seconds.
std::string heard(fast::DataReader* reader, const std::function<void()>& speak) {
  for (int i = 0; i < 100; ++i) {
    speak();
    std::this_thread::sleep_for(milliseconds(100));
    std::string bytes;
    fast::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) return bytes;
    }
  }
  return {};
}

/// A message that is a list, up to where its first element goes on after a header and a name.
struct ListOfStamped {
  explicit ListOfStamped(std::string& bytes) : buffer(bytes.data(), bytes.size()) {
    cdr.read_encapsulation();
    cdr >> count >> seconds >> nanoseconds >> frame >> name;
  }

  FastBuffer buffer;
  Cdr cdr{buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR};
  std::uint32_t count = 0;
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  std::string frame;
  std::string name;
};

TEST(FastDds, HearsTheTransform) {
  DdsNode node(other_domain(), true);
  MapTopics topics(node, "evermap", "map");
  FastNode other;
  fast::DataReader* reader = other.reader("/tf", "tf2_msgs::msg::dds_::TFMessage_");
  std::string bytes = heard(reader, [&] {
    topics.send_transform(12.25, "odom", {Eigen::Matrix3d::Identity(), {1, 2, 3}});
  });
  ASSERT_FALSE(bytes.empty());
  ListOfStamped transforms(bytes);
  double x = 0;
  double y = 0;
  double z = 0;
  transforms.cdr >> x >> y >> z;
  EXPECT_EQ(transforms.count, 1U);
  EXPECT_EQ(transforms.seconds, 12);
  EXPECT_EQ(transforms.nanoseconds, 250000000U);
  EXPECT_EQ(transforms.frame, "map");
  EXPECT_EQ(transforms.name, "odom");
  EXPECT_EQ(Eigen::Vector3d(x, y, z), Eigen::Vector3d(1, 2, 3));
}

TEST(FastDds, HearsWhatChangedAsHumblesMarkers) {
  DdsNode node(other_domain(), true);
  MapTopics topics(node, "evermap", "map");
  FastNode other;
  fast::DataReader* reader = other.reader("/evermap/changes", "visualization_msgs::msg::dds_::MarkerArray_");
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 3, 4));
  std::string bytes = heard(reader, [&] { topics.send_changes(5, {{false, box, 17}}); });
  ASSERT_FALSE(bytes.empty());
  ListOfStamped markers(bytes);
  Cdr& cdr = markers.cdr;
  std::int32_t seconds = 0;
  std::uint32_t number = 0;
  std::array<std::int32_t, 3> id_type_action{};
  std::array<double, 7> pose{};
  std::array<double, 3> scale{};
  std::array<float, 4> color{};
  bool flag = false;
  std::string empty;
  std::string words;
  for (std::int32_t& value : id_type_action) cdr >> value;
  for (double& value : pose) cdr >> value;
  for (double& value : scale) cdr >> value;
  for (float& value : color) cdr >> value;
  cdr >> seconds >> number >> flag;
  for (const char* list : {"points", "colors"}) {
    cdr >> number;
    EXPECT_EQ(number, 0U) << list;
  }
  cdr >> empty >> seconds >> number >> empty >> empty >> number >> number >> words >> empty >> empty >>
      number >> flag;
  EXPECT_EQ(markers.count, 1U);
  EXPECT_EQ(markers.name, "went");
  EXPECT_EQ(id_type_action[1], 1);  // a cube
  EXPECT_EQ(pose[2], 2);
  EXPECT_EQ(scale[1], 3);
  EXPECT_TRUE(words.starts_with("went, 17 leaves")) << words;
  EXPECT_LT(bytes.size() - cdr.getSerializedDataLength(), 4U);  // all but what fills the last four bytes
}

TEST(FastDds, HearsTheDiagnosis) {
  DdsNode node(other_domain(), true);
  MapTopics topics(node, "evermap", "map");
  FastNode other;
  fast::DataReader* reader = other.reader("/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_");
  const std::string bytes = heard(reader, [&] {
    topics.send_diagnosis(1, {Diagnosis::kWarning, "lost: somewhere", {{"state", "lost"}}});
  });
  EXPECT_NE(bytes.find("lost: somewhere"), std::string::npos);
}

}  // namespace
}  // namespace evermap
