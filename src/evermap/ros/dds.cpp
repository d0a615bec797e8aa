// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <dds/ddsi/ddsi_serdata.h>
#include <memory>
#include <utility>

#include <evermap/ros/detail/dds.hpp>

namespace evermap {
namespace {

// Clouds are large: a socket's usual buffer holds a tenth of one, and a message's usual size makes a thousand
// of it.
constexpr const char* kSizes = R"(<Domain>
  <General><MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize></General>
  <Internal><SocketReceiveBufferSize max="16MiB"/><MaxSampleSize>256MiB</MaxSampleSize></Internal>
</Domain>)";
// Loopback without multicast works everywhere, in containers too.
constexpr const char* kLocal = R"(<Domain>
  <General>
    <Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>50</MaxAutoParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
</Domain>)";

/// The user's own configuration goes before ours, as with any program on Cyclone DDS.
std::string configuration(bool is_local) {
  const char* given = std::getenv("CYCLONEDDS_URI");
  return std::string(kSizes) + (is_local ? "," + std::string(kLocal) : "") +
         (given ? "," + std::string(given) : "");
}

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

Qos qos_of(Delivery delivery, int depth) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  constexpr dds_duration_t kPatience = DDS_MSECS(100);
  const bool is_reliable = delivery != Delivery::kSensorData;
  dds_qset_reliability(qos.get(), is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kPatience);
  dds_qset_durability(
      qos.get(), delivery == Delivery::kLatched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

/// The domain as this process is to see it; none when another node of this process has configured it already.
DdsEntity configure(unsigned domain, bool is_local) {
  const dds_entity_t entity = dds_create_domain(domain, configuration(is_local).c_str());
  return {entity == DDS_RETCODE_PRECONDITION_NOT_MET ? 0 : entity, "ROS domain " + std::to_string(domain)};
}

std::string name_on_dds(const std::string& topic) { return "rt" + topic; }

/// tf2_msgs/TFMessage of tf2_msgs::msg::dds_::TFMessage_
std::string type_in_ros(const std::string& name) {
  const std::size_t last = name.rfind(':') + 1;
  return name.substr(0, name.find(':')) + "/" + name.substr(last, name.size() - 1 - last);
}

}  // namespace

DdsEntity::DdsEntity(dds_entity_t entity, const std::string& what) : entity_(entity) {
  if (entity < 0) throw DdsError(what + ": " + dds_strretcode(entity));
}

DdsEntity::~DdsEntity() {
  if (entity_ > 0) dds_delete(entity_);
}

DdsNode::DdsNode(unsigned domain, bool is_local)
    : domain_(configure(domain, is_local)),
      participant_(dds_create_participant(domain, nullptr, nullptr),
                   "ROS domain " + std::to_string(domain) + " cannot be joined"),
      waitset_(dds_create_waitset(participant_.get()), "waiting for messages") {}

void DdsNode::wait(double seconds) {
  dds_waitset_wait(waitset_.get(), nullptr, 0, static_cast<dds_duration_t>(std::llround(seconds * 1e9)));
}

DdsReader::DdsReader(DdsNode& node, const std::string& topic, const dds_topic_descriptor_t& type,
                     Delivery delivery, int depth)
    : topic_{topic, type_in_ros(type.m_typename), Wire::kCdr},
      depth_(static_cast<std::size_t>(depth)),
      dds_topic_(dds_create_topic(node.participant(), &type, name_on_dds(topic).c_str(), nullptr, nullptr),
                 "topic " + topic),
      reader_(dds_create_reader(node.participant(), dds_topic_.get(), qos_of(delivery, depth).get(), nullptr),
              "subscription of " + topic) {
  dds_set_status_mask(reader_.get(), DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(node.waitset_.get(), reader_.get(), 0);
}

std::vector<DdsMessage> DdsReader::take() {
  std::vector<DdsMessage> messages;
  std::vector<ddsi_serdata*> data(depth_);
  std::vector<dds_sample_info_t> infos(depth_);
  const dds_return_t count = dds_takecdr(reader_.get(), data.data(), static_cast<std::uint32_t>(depth_),
                                         infos.data(), DDS_ANY_STATE);
  messages.reserve(depth_);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    if (infos[i].valid_data) {  // else it is news of a writer that went
      DdsMessage& message = messages.emplace_back();
      message.writer = infos[i].publication_handle;
      message.bytes.resize(ddsi_serdata_size(data[i]));
      ddsi_serdata_to_ser(data[i], 0, message.bytes.size(), message.bytes.data());
    }
    ddsi_serdata_unref(data[i]);
  }
  return messages;
}

std::size_t DdsReader::writers() const {
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(reader_.get(), &status);
  return status.current_count;
}

DdsWriter::DdsWriter(DdsNode& node, const std::string& topic, const dds_topic_descriptor_t& type,
                     Delivery delivery)
    : name_(topic),
      topic_(dds_create_topic(node.participant(), &type, name_on_dds(topic).c_str(), nullptr, nullptr),
             "topic " + topic),
      writer_(dds_create_writer(node.participant(), topic_.get(),
                                qos_of(delivery, delivery == Delivery::kLatched ? 1 : 10).get(), nullptr),
              "publisher of " + topic) {}

void DdsWriter::write(const void* message) {
  const dds_return_t code = dds_write(writer_.get(), message);
  // A listener that does not keep up must not hold up the rest.
  if (code < 0 && code != DDS_RETCODE_TIMEOUT) throw DdsError(name_ + ": " + dds_strretcode(code));
}

std::size_t DdsWriter::readers() const {
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(writer_.get(), &status);
  return status.current_count;
}

}  // namespace evermap
