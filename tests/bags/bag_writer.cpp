// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bags/bag_writer.hpp"

#include <bzlib.h>
#include <cmath>
#include <lz4frame.h>
#include <map>
#include <sqlite3.h>
#include <zlib.h>

#include <Eigen/Geometry>
#include <zstd.h>

namespace evermap {
namespace {

std::uint64_t nanoseconds(double time) { return static_cast<std::uint64_t>(std::llround(time * 1e9)); }

/// A length, and the bytes.
std::string block(const std::string& bytes) {
  return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(bytes.size())}) + bytes;
}

template <class T>
std::string ros1_field(const std::string& name, T value) {
  return block(name + "=" + bytes_of<T>({value}));
}
std::string ros1_field(const std::string& name, const std::string& value) {
  return block(name + "=" + value);
}
std::string ros1_op(std::uint8_t op) { return ros1_field("op", op); }
std::string ros1_record(const std::string& header, const std::string& data) {
  return block(header) + block(data);
}
std::string ros1_time(double time) {
  const auto seconds = static_cast<std::uint32_t>(std::floor(time));
  const auto rest = static_cast<std::uint32_t>(std::llround((time - seconds) * 1e9));
  return bytes_of<std::uint32_t>({seconds, rest});
}

/// Numbers of the topics, in the order in which they come.
std::map<std::string, std::uint32_t> numbers_of(const std::vector<WrittenMessage>& messages) {
  std::map<std::string, std::uint32_t> numbers;
  for (const WrittenMessage& message : messages)
    numbers.emplace(message.topic, static_cast<std::uint32_t>(numbers.size()));
  return numbers;
}

std::string mcap_record(std::uint8_t op, const std::string& content) {
  return bytes_of<std::uint8_t>({op}) + bytes_of<std::uint64_t>({content.size()}) + content;
}
std::string mcap_channels(const std::vector<WrittenMessage>& messages, Wire wire) {
  std::string records;
  std::map<std::string, std::uint32_t> written;
  const std::map<std::string, std::uint32_t> numbers = numbers_of(messages);
  for (const WrittenMessage& message : messages) {
    if (!written.emplace(message.topic, 0).second) continue;
    const auto id = static_cast<std::uint16_t>(numbers.at(message.topic) + 1);
    std::string type = message.type;
    if (wire == Wire::kCdr) type.replace(type.find('/'), 1, "/msg/");
    records += mcap_record(
        3, bytes_of<std::uint16_t>({id}) + block(type) + block("ros2msg") + block("# definition"));
    records += mcap_record(4, bytes_of<std::uint16_t>({id, id}) + block(message.topic) +
                                  block(wire == Wire::kCdr ? "cdr" : "ros1") + block(""));
  }
  return records;
}

void run(sqlite3* database, const std::string& statement) {
  char* error = nullptr;
  if (::sqlite3_exec(database, statement.c_str(), nullptr, nullptr, &error) != SQLITE_OK) {
    ADD_FAILURE() << statement << ": " << error;
    ::sqlite3_free(error);
  }
}

}  // namespace

std::string cloud_message(Wire wire, double time, const std::string& frame,
                          const std::vector<CloudPoint>& points, std::endian order) {
  WireWriter message(wire, order);
  message.header(time, frame).number<std::uint32_t>(1).number(static_cast<std::uint32_t>(points.size()));
  message.number<std::uint32_t>(4);
  const auto field = [&](const std::string& name, std::uint32_t offset) {
    message.text(name).number(offset).number<std::uint8_t>(7).number<std::uint32_t>(1);
  };
  field("x", 0);
  field("y", 4);
  field("z", 8);
  field("time", 18);
  constexpr std::uint32_t kStep = 24;
  message.number<std::uint8_t>(order == std::endian::big ? 1 : 0);
  message.number(kStep).number(static_cast<std::uint32_t>(kStep * points.size()));
  message.number(static_cast<std::uint32_t>(kStep * points.size()));
  for (const CloudPoint& point : points) {
    message.raw(bytes_of<float>({point.x, point.y, point.z}, order) + std::string(6, '\x7f') +
                bytes_of<float>({point.time}, order) + std::string(2, '\x7f'));
  }
  return message.number<std::uint8_t>(1).bytes();
}

std::string transform_message(Wire wire, double time, const std::string& parent, const std::string& child,
                              const Pose& T_parent_child) {
  WireWriter message(wire);
  return message.number<std::uint32_t>(1).header(time, parent).text(child).pose(T_parent_child).bytes();
}

std::string odometry_message(Wire wire, double time, const std::string& frame, const std::string& child,
                             const Pose& T_frame_child) {
  WireWriter message(wire);
  message.header(time, frame).text(child).pose(T_frame_child);
  for (int i = 0; i < 36 + 6 + 36; ++i) message.number(0.0);
  return message.bytes();
}

std::string imu_message(Wire wire, double time, const std::string& frame, const Eigen::Vector3d& rate) {
  WireWriter message(wire);
  message.header(time, frame);
  for (int i = 0; i < 4 + 9; ++i) message.number(0.0);
  for (const double axis : rate) message.number(axis);
  for (int i = 0; i < 9 + 3 + 9; ++i) message.number(0.0);
  return message.bytes();
}

std::string compressed(const std::string& bytes, const std::string& compression) {
  if (compression == "none") return bytes;
  std::string output(2 * bytes.size() + 1000, '\0');
  if (compression == "bz2") {
    auto size = static_cast<unsigned>(output.size());
    std::string input = bytes;
    EXPECT_EQ(::BZ2_bzBuffToBuffCompress(output.data(), &size, input.data(),
                                         static_cast<unsigned>(input.size()), 9, 0, 0),
              BZ_OK);
    output.resize(size);
  } else if (compression == "lz4") {
    output.resize(::LZ4F_compressFrame(output.data(), output.size(), bytes.data(), bytes.size(), nullptr));
  } else {
    output.resize(::ZSTD_compress(output.data(), output.size(), bytes.data(), bytes.size(), 3));
  }
  return output;
}

std::string ros1_bag(const std::vector<WrittenMessage>& messages, const BagStyle& style) {
  const std::map<std::string, std::uint32_t> numbers = numbers_of(messages);
  const auto connection = [&](const WrittenMessage& message) {
    const std::string header =
        ros1_op(7) + ros1_field("conn", numbers.at(message.topic)) + ros1_field("topic", message.topic);
    return ros1_record(header, ros1_field("topic", message.topic) + ros1_field("type", message.type) +
                                   ros1_field("md5sum", std::string(32, '0')));
  };
  const auto bag_header = [&](std::uint64_t index) {
    return ros1_record(ros1_op(3) + ros1_field("index_pos", index) +
                           ros1_field<std::uint32_t>("conn_count", 0) +
                           ros1_field<std::uint32_t>("chunk_count", 0),
                       std::string(40, ' '));
  };
  const std::string magic = "#ROSBAG V2.0\n";
  const std::size_t head = magic.size() + bag_header(0).size();
  std::string chunks, index;
  std::map<std::string, bool> is_written;
  for (std::size_t begin = 0; begin < messages.size(); begin += style.messages_per_chunk) {
    std::string content;
    std::map<std::uint32_t, std::uint32_t> counts;
    for (std::size_t i = begin; i < std::min(begin + style.messages_per_chunk, messages.size()); ++i) {
      const WrittenMessage& message = messages[i];
      const std::uint32_t number = numbers.at(message.topic);
      if (!std::exchange(is_written[message.topic], true)) {
        content += connection(message);
        index += connection(message);
      }
      content +=
          ros1_record(ros1_op(2) + ros1_field("conn", number) + ros1_field("time", ros1_time(message.time)),
                      message.bytes);
      ++counts[number];
    }
    std::string entries;
    for (const auto& [number, count] : counts) entries += bytes_of<std::uint32_t>({number, count});
    index += ros1_record(ros1_op(6) + ros1_field<std::uint32_t>("ver", 1) +
                             ros1_field<std::uint64_t>("chunk_pos", head + chunks.size()),
                         entries);
    chunks += ros1_record(ros1_op(5) + ros1_field("compression", style.compression) +
                              ros1_field("size", static_cast<std::uint32_t>(content.size())),
                          compressed(content, style.compression));
    chunks += ros1_record(ros1_op(4) + ros1_field<std::uint32_t>("ver", 1), "entries");
  }
  if (!style.has_index) return magic + bag_header(0) + chunks;
  return magic + bag_header(head + chunks.size()) + chunks + index;
}

std::string mcap_bag(const std::vector<WrittenMessage>& messages, Wire wire, const BagStyle& style) {
  const std::string magic("\x89MCAP0\r\n", 8);
  const std::string channels = mcap_channels(messages, wire);
  const std::map<std::string, std::uint32_t> numbers = numbers_of(messages);
  std::string data =
      magic + mcap_record(1, block(wire == Wire::kCdr ? "ros2" : "ros1") + block("evermap's tests"));
  std::map<std::uint16_t, std::uint64_t> counts;
  for (std::size_t begin = 0; begin < messages.size(); begin += style.messages_per_chunk) {
    std::string content = begin == 0 ? channels : "";
    for (std::size_t i = begin; i < std::min(begin + style.messages_per_chunk, messages.size()); ++i) {
      const auto id = static_cast<std::uint16_t>(numbers.at(messages[i].topic) + 1);
      const std::uint64_t time = nanoseconds(messages[i].time);
      content += mcap_record(5, bytes_of<std::uint16_t>({id}) + bytes_of<std::uint32_t>({1}) +
                                    bytes_of<std::uint64_t>({time, time}) + messages[i].bytes);
      ++counts[id];
    }
    if (style.messages_per_chunk == 1) {  // without chunks
      data += content;
      continue;
    }
    const auto checksum = static_cast<std::uint32_t>(
        ::crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())));
    const std::string packed = compressed(content, style.compression);
    data +=
        mcap_record(6, bytes_of<std::uint64_t>({0, 0, content.size()}) + bytes_of<std::uint32_t>({checksum}) +
                           block(style.compression == "none" ? "" : style.compression) +
                           bytes_of<std::uint64_t>({packed.size()}) + packed);
    data += mcap_record(7, "an index");
  }
  data += mcap_record(15, bytes_of<std::uint32_t>({0}));
  std::uint64_t summary = 0;
  if (style.has_index) {
    summary = data.size();
    std::string entries;
    for (const auto& [id, count] : counts)
      entries += bytes_of<std::uint16_t>({id}) + bytes_of<std::uint64_t>({count});
    data += channels + mcap_record(11, std::string(8 + 2 + 4 + 4 + 4 + 4 + 8 + 8, '\1') + block(entries));
  }
  return data + mcap_record(2, bytes_of<std::uint64_t>({summary, 0}) + bytes_of<std::uint32_t>({0})) + magic;
}

void write_sqlite_bag(const std::filesystem::path& path, const std::vector<WrittenMessage>& messages,
                      const BagStyle& style) {
  std::filesystem::remove(path);
  sqlite3* database = nullptr;
  ASSERT_EQ(::sqlite3_open(path.c_str(), &database), SQLITE_OK);
  run(database, "PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF");
  run(database,
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
      "serialization_format TEXT "
      "NOT NULL, offered_qos_profiles TEXT NOT NULL)");
  run(database,
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
      "data BLOB "
      "NOT NULL)");
  run(database, "CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
  std::map<std::string, bool> is_written;
  const std::map<std::string, std::uint32_t> numbers = numbers_of(messages);
  run(database, "BEGIN");
  for (const WrittenMessage& message : messages) {
    const std::string id = std::to_string(numbers.at(message.topic) + 1);
    if (!std::exchange(is_written[message.topic], true)) {
      std::string type = message.type;
      type.replace(type.find('/'), 1, "/msg/");
      run(database,
          "INSERT INTO topics VALUES(" + id + ", '" + message.topic + "', '" + type + "', 'cdr', '')");
    }
    sqlite3_stmt* statement = nullptr;
    const std::string insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES(" + id + ", " +
                               std::to_string(nanoseconds(message.time)) + ", ?)";
    ASSERT_EQ(::sqlite3_prepare_v2(database, insert.c_str(), -1, &statement, nullptr), SQLITE_OK);
    const std::string data = compressed(message.bytes, style.compression);
    ::sqlite3_bind_blob(statement, 1, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(::sqlite3_step(statement), SQLITE_DONE);
    ::sqlite3_finalize(statement);
  }
  run(database, "COMMIT");
  ::sqlite3_close(database);
}

}  // namespace evermap
