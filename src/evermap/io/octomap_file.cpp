// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <evermap/files/detail/expansion.hpp>
#include <evermap/files/detail/input_file.hpp>
#include <evermap/files/detail/record_layout.hpp>
#include <evermap/files/detail/text_lines.hpp>
#include <evermap/io/detail/octomap_file.hpp>

namespace evermap {
namespace {

/// The lines in front of the nodes.
struct OctomapHeader {
  bool is_binary = false;  ///< .bt
  std::string tree;
  double size = 0;        ///< nodes
  double resolution = 0;  ///< [m]
  std::size_t data = 0;   ///< [bytes] where the nodes begin
};

OctomapHeader read_octomap_header(const InputFile& file) {
  OctomapHeader header;
  TextLines lines(file);
  if (!lines.next() || !lines.line().starts_with("# Octomap OcTree ")) file.fail("is no OctoMap");
  header.is_binary = lines.line().find("binary") != std::string_view::npos;
  while (lines.next()) {
    std::string_view line = lines.line();
    const std::string_view key = next_token(line);
    const std::string_view value = next_token(line);
    if (key == "id") header.tree = value;
    if (key == "size" || key == "res") {
      const std::optional<double> number = parse_number(value);
      if (!number || !std::isfinite(*number) || *number < 0) lines.fail("has no number: " + in_quotes(value));
      (key == "size" ? header.size : header.resolution) = *number;
    }
    if (key == "data") {
      header.data = lines.offset();
      return header;
    }
  }
  file.fail("ends inside its header; copy the file again");
}

/// Walks the nodes of the tree, which are written depth first.
class OctomapReader {
 public:
  OctomapReader(const InputFile& file, const OctomapHeader& header)
      : file_(file),
        header_(header),
        is_coloured_(header.tree == "ColorOcTree"),
        most_(greatest_expansion(file.bytes().size()) / sizeof(Eigen::Vector3d)),
        position_(header.data) {}

  Scan read() {
    if (header_.size > 0) header_.is_binary ? read_binary(kRoot) : read_full(kRoot);
    return std::move(scan_);
  }

 private:
  /// A cube of voxels, of which there are 2^16 along an axis; the map's origin is in the middle.
  struct Node {
    std::array<std::uint32_t, 3> begin;
    std::uint32_t size;

    Node child(unsigned index) const {
      const std::uint32_t half = size / 2;
      return {{begin[0] + (index & 1 ? half : 0), begin[1] + (index & 2 ? half : 0),
               begin[2] + (index & 4 ? half : 0)},
              half};
    }
  };
  static constexpr std::uint32_t kSide = 1U << 16;
  static constexpr double kMiddle = 1U << 15;
  static constexpr Node kRoot{{0, 0, 0}, kSide};

  double take(Scalar type) {
    if (file_.bytes().size() - position_ < size_of(type))
      file_.fail_at_byte(file_.bytes().size(), "ends inside its tree; copy the file again");
    const double value = decode(file_.bytes().data() + position_, type, std::endian::little);
    position_ += size_of(type);
    return value;
  }

  /// Two bits a child: its kind.
  void read_binary(const Node& node) {
    enum Kind : unsigned { kUnknown, kFree, kOccupied, kInner };
    const auto kinds = static_cast<unsigned>(take(Scalar::kUint16));
    const auto kind = [&](unsigned child) { return (kinds >> (2 * child)) & 3U; };
    for (unsigned child = 0; child < 8; ++child) {
      if (kind(child) == kOccupied) add(node.child(child));
    }
    for (unsigned child = 0; child < 8; ++child) {
      if (kind(child) == kInner) read_inner(node, child, &OctomapReader::read_binary);
    }
  }

  /// Its log-odds, and a bit for each child that follows.
  void read_full(const Node& node) {
    const double log_odds = take(Scalar::kFloat32);
    for (int colour = 0; is_coloured_ && colour < 3; ++colour) take(Scalar::kUint8);
    const auto children = static_cast<unsigned>(take(Scalar::kUint8));
    if (children == 0 && log_odds >= 0) add(node);
    for (unsigned child = 0; child < 8; ++child) {
      if ((children >> child) & 1U) read_inner(node, child, &OctomapReader::read_full);
    }
  }

  void read_inner(const Node& node, unsigned child, void (OctomapReader::*read_node)(const Node&)) {
    if (node.size == 1) file_.fail_at_byte(position_, "has a tree deeper than 16 levels; export it again");
    (this->*read_node)(node.child(child));
  }

  void add(const Node& node) {
    const std::uint64_t count = std::uint64_t{node.size} * node.size * node.size;
    if (count > most_ - scan_.p_sensor.size())
      file_.fail_at_byte(position_, "holds more than " + std::to_string(most_) + " occupied voxels");
    const auto center = [&](int axis, std::uint32_t step) {
      return (static_cast<double>(node.begin[axis] + step) - kMiddle + 0.5) * header_.resolution;
    };
    for (std::uint32_t x = 0; x < node.size; ++x) {
      for (std::uint32_t y = 0; y < node.size; ++y) {
        for (std::uint32_t z = 0; z < node.size; ++z)
          scan_.p_sensor.emplace_back(center(0, x), center(1, y), center(2, z));
      }
    }
  }

  const InputFile& file_;
  const OctomapHeader& header_;
  bool is_coloured_;
  std::uint64_t most_;    ///< voxels that there may be
  std::size_t position_;  ///< [bytes]
  Scan scan_;
};

}  // namespace

Scan read_octomap(const std::filesystem::path& path, CloudNotes* notes) {
  const InputFile file(path);
  const OctomapHeader header = read_octomap_header(file);
  if (header.tree != "OcTree" && (header.is_binary || header.tree != "ColorOcTree")) {
    file.fail("is an octree of kind " + in_quotes(header.tree) + "; OcTree and ColorOcTree are read");
  }
  if (!(header.resolution > 0)) file.fail("has no resolution in its header; export it again");
  if (notes != nullptr) {
    *notes = {};
    notes->voxel = header.resolution;
  }
  return OctomapReader(file, header).read();
}

}  // namespace evermap
