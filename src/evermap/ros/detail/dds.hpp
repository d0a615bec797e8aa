// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <dds/dds.h>
#include <stdexcept>
#include <string>
#include <vector>

#include <evermap/bags/detail/bag_reader.hpp>

namespace evermap {

/// What DDS refused, with its own word for it.
struct DdsError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// How messages of a topic are delivered, by ROS's conventions.
enum class Delivery {
  kSensorData,  ///< what is lost is lost
  kReliable,    ///< to those who are there
  kLatched,     ///< the last one also to those who come later
};

/// An entity of DDS, which goes with this object.
class DdsEntity {
 public:
  /// Takes the entity; throws DdsError when there is none, naming `what` was to be made.
  DdsEntity(dds_entity_t entity, const std::string& what);
  ~DdsEntity();
  DdsEntity(const DdsEntity&) = delete;
  DdsEntity& operator=(const DdsEntity&) = delete;

  dds_entity_t get() const { return entity_; }

 private:
  dds_entity_t entity_;
};

/// A message as it came.
struct DdsMessage {
  std::string bytes;         ///< in CDR, as WireReader reads it
  std::uint64_t writer = 0;  ///< a number of who sent it
};

/// A participant in a ROS domain. Topics are named as in ROS: /points. Not thread safe.
class DdsNode {
 public:
  /// `is_local`: speaks with this machine alone. The first node of a process decides that for the domain, and
  /// must outlive the others. Throws DdsError when the network cannot be used.
  DdsNode(unsigned domain, bool is_local);

  dds_entity_t participant() const { return participant_.get(); }
  /// Waits up to `seconds` for messages in any reader.
  void wait(double seconds);

 private:
  friend class DdsReader;

  DdsEntity domain_;
  DdsEntity participant_;
  DdsEntity waitset_;
};

/// Receives the messages of a topic, but none that this node sends.
class DdsReader {
 public:
  DdsReader(DdsNode& node, const std::string& topic, const dds_topic_descriptor_t& type, Delivery delivery,
            int depth);

  /// What came since, in that order; of more than the depth, the last.
  std::vector<DdsMessage> take();
  /// How many send to this topic now.
  std::size_t writers() const;
  /// Its name and type, as the readers of messages want them told.
  const BagTopic& topic() const { return topic_; }

 private:
  BagTopic topic_;
  std::size_t depth_;
  DdsEntity dds_topic_;
  DdsEntity reader_;
};

/// Sends messages, which are the C types that idlc makes of ros_messages.idl.
class DdsWriter {
 public:
  DdsWriter(DdsNode& node, const std::string& topic, const dds_topic_descriptor_t& type, Delivery delivery);

  /// REQUIRES: the message is of the writer's type. Throws DdsError when it is not taken.
  void write(const void* message);
  /// How many listen to this topic now.
  std::size_t readers() const;

 private:
  std::string name_;
  DdsEntity topic_;
  DdsEntity writer_;
};

}  // namespace evermap
