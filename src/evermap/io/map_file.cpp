// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include <xxhash.h>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

static_assert(std::endian::native == std::endian::little, "the records below are copied as they stand");

constexpr std::string_view kMagic =
    "\x89"
    "EVM\r\n\x1a\n";  // as PNG's: damaged by whatever alters text
constexpr std::string_view kEndMark = "EVM-END\n";

struct Header {
  std::array<char, 8> magic;
  std::uint32_t format;
  std::uint32_t record_size;  ///< [bytes]
  double edge;                ///< [m]
  double origin[3];           ///< [m] map frame
  std::uint64_t leaves;
  std::uint64_t blocks;
  std::uint64_t checksum;  ///< of all above
};
static_assert(sizeof(Header) == 72);

struct BlockHeader {
  std::uint64_t key;
  std::uint32_t leaves;
  std::uint32_t payload_size;  ///< [bytes] of the records that follow
};
static_assert(sizeof(BlockHeader) == 16);

struct Record {
  std::uint32_t key_in_block;
  float mean_in_voxel[3];  ///< [m] from the voxel's centre
  float covariance[6];     ///< [m^2] xx xy xz yy yz zz
  float count;
  float log_odds;
};
static_assert(sizeof(Record) == 48);

using Checksum = std::uint64_t;

constexpr std::size_t kLongestFrameName = 255;  ///< [bytes]

Checksum checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

template <class T>
std::string_view bytes_of(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

template <class T>
T take(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

Record to_record(VoxelKey key, const Leaf& leaf) {
  Record record{};
  record.key_in_block = key.voxel_in_block();
  std::copy_n(leaf.mean_in_voxel.data(), 3, record.mean_in_voxel);
  std::copy_n(leaf.covariance.data(), 6, record.covariance);
  record.count = leaf.count;
  record.log_odds = leaf.log_odds;
  return record;
}

Leaf to_leaf(const Record& record) {
  Leaf leaf;
  std::copy_n(record.mean_in_voxel, 3, leaf.mean_in_voxel.data());
  std::copy_n(record.covariance, 6, leaf.covariance.data());
  leaf.count = record.count;
  leaf.log_odds = record.log_odds;
  return leaf;
}

bool is_sound(const Leaf& leaf) { return leaf.is_finite() && leaf.count > 0; }

std::uint64_t count_blocks(const Octree& octree) {
  std::uint64_t blocks = 0;
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  octree.for_each_leaf([&](VoxelKey key, const Leaf&) {
    blocks += key.block() != last;
    last = key.block();
  });
  return blocks;
}

constexpr std::uint32_t kFormatWithoutFrame = 1;

/// What follows the header in format 2, behind it the name, and then the checksum of both.
struct FrameHeader {
  std::uint32_t name_size;   ///< [bytes]
  std::uint32_t has_origin;  ///< 0 or 1
  double origin[3];          ///< [degrees, degrees, m] latitude, longitude, altitude
};
static_assert(sizeof(FrameHeader) == 32);

std::string bytes_of_frame(const MapFrame& frame) {
  FrameHeader header{static_cast<std::uint32_t>(frame.name.size()), frame.origin ? 1U : 0U, {}};
  if (frame.origin) {
    header.origin[0] = frame.origin->latitude;
    header.origin[1] = frame.origin->longitude;
    header.origin[2] = frame.origin->altitude;
  }
  std::string bytes(bytes_of(header));
  bytes += frame.name;
  bytes += bytes_of(checksum(bytes));
  return bytes;
}

Header header_of(const Octree& octree) {
  const VoxelGrid& grid = octree.grid();
  const std::uint32_t format = octree.frame() == MapFrame{} ? kFormatWithoutFrame : kMapFormat;
  Header header{{}, format, sizeof(Record), grid.edge, {}, octree.leaf_count(), count_blocks(octree), 0};
  std::copy(kMagic.begin(), kMagic.end(), header.magic.begin());
  std::copy_n(grid.origin.data(), 3, header.origin);
  header.checksum = checksum(bytes_of(header).substr(0, sizeof(Header) - sizeof(Checksum)));
  return header;
}

/// Gathers the leaves of one block, then writes them as one section.
class BlockWriter {
 public:
  explicit BlockWriter(AtomicFile& file) : file_(file) {}

  void add(VoxelKey key, const Record& record) {
    if (section_.empty() || key.block() != block_) {
      flush();
      block_ = key.block();
      section_.assign(sizeof(BlockHeader), '\0');
    }
    section_ += bytes_of(record);
  }

  void flush() {
    if (section_.empty()) return;
    const auto payload = static_cast<std::uint32_t>(section_.size() - sizeof(BlockHeader));
    const BlockHeader header{block_, payload / static_cast<std::uint32_t>(sizeof(Record)), payload};
    std::memcpy(section_.data(), &header, sizeof(header));
    file_.write(section_);
    file_.write(bytes_of(checksum(section_)));
    section_.clear();
  }

 private:
  AtomicFile& file_;
  std::uint64_t block_ = 0;
  std::string section_;
};

/// Gathers the leaves of one brick after the other, and puts each brick into the map at once.
class BrickReader {
 public:
  explicit BrickReader(Octree& octree) : octree_(octree) {}

  /// REQUIRES: keys ascend.
  void add(VoxelKey key, const Leaf& leaf) {
    if (!leaves_.empty() && key.brick() != key_.brick()) finish();
    key_ = key;
    mask_.set(key.voxel_in_brick());
    leaves_.push_back(leaf);
  }

  void finish() {
    if (leaves_.empty()) return;
    octree_.insert_brick(key_, Brick(mask_, {leaves_.begin(), leaves_.end()}));
    mask_ = {};
    leaves_.clear();
  }

 private:
  Octree& octree_;
  VoxelKey key_;
  Mask512 mask_;
  std::vector<Leaf> leaves_;  ///< of the brick in hand; copied without spare capacity
};

/// Takes a map file apart, section by section, and lets nothing pass that was not written. No more than one
/// section is in memory.
class MapReader {
 public:
  explicit MapReader(const std::filesystem::path& path) : file_(path), header_(read_header()) {}

  Octree read() {
    const Eigen::Map<const Eigen::Vector3d> origin(header_.origin);
    const VoxelGrid grid{header_.edge,
                         origin + Eigen::Vector3d::Zero()};  // as VoxelGrid::around() makes them
    Octree octree(grid, header_.format == kFormatWithoutFrame ? MapFrame{} : read_frame());
    for (block_ = 0; block_ < header_.blocks; ++block_) read_block(octree);
    next(std::min<std::uint64_t>(kEndMark.size(), file_.rest()));
    if (section_ != kEndMark) fail("the mark of the map's end is missing");
    if (file_.rest() > 0) {
      offset_ = file_.position();
      fail(std::to_string(file_.rest()) + " bytes follow the map's end");
    }
    if (octree.leaf_count() != header_.leaves) {
      fail("holds " + std::to_string(octree.leaf_count()) + " leaves, the header says " +
           std::to_string(header_.leaves));
    }
    return octree;
  }

 private:
  /// Makes the next bytes of the file the section in hand.
  void next(std::size_t size) {
    offset_ = file_.position();
    section_.clear();
    file_.append_to(section_, size);
  }

  [[noreturn]] void fail_at(std::uint64_t offset, const std::string& what) const {
    throw FileError::at_byte(file_.path(), offset, what);
  }
  [[noreturn]] void fail(const std::string& what) const {
    fail_at(offset_, what + "; the map is damaged, restore it from a copy");
  }
  [[noreturn]] void fail_in_block(std::uint64_t offset, const std::string& what) const {
    fail_at(offset, "block " + std::to_string(block_ + 1) + " of " + std::to_string(header_.blocks) + ": " +
                        what + "; the map is damaged, restore it from a copy");
  }

  /// Whether the header's checksum fits when its format is this one. A version that only a fault has raised
  /// shows by the checksum of our own.
  static bool is_sealed(Header header, std::uint32_t format) {
    header.format = format;
    return header.checksum == checksum(bytes_of(header).substr(0, sizeof(Header) - sizeof(Checksum)));
  }

  Header read_header() {
    next(std::min<std::uint64_t>(sizeof(Header), file_.rest()));
    if (!section_.starts_with(kMagic)) fail_at(0, "is no evermap map (.evm)");
    if (section_.size() < sizeof(Header)) fail("ends inside the header");
    const auto header = take<Header>(section_, 0);
    const bool is_raised = is_sealed(header, kFormatWithoutFrame) || is_sealed(header, kMapFormat);
    if (header.format > kMapFormat && !is_raised) {
      fail_at(offsetof(Header, format), "made by a newer evermap: format " + std::to_string(header.format) +
                                            ", this program reads up to " + std::to_string(kMapFormat) +
                                            "; update evermap");
    }
    if (!is_sealed(header, header.format)) fail("the header's checksum does not fit");
    if (header.format < kFormatWithoutFrame || header.format > kMapFormat ||
        header.record_size != sizeof(Record))
      fail("the header makes no sense");
    const bool is_finite =
        std::all_of(header.origin, header.origin + 3, [](double x) { return std::isfinite(x); });
    if (!is_leaf_edge(header.edge) || !is_finite) fail("the header's grid makes no sense");
    return header;
  }

  MapFrame read_frame() {
    if (file_.rest() < sizeof(FrameHeader)) fail("ends inside the frame's name");
    next(sizeof(FrameHeader));
    const auto header = take<FrameHeader>(section_, 0);
    if (header.name_size > kLongestFrameName) fail("the frame's name makes no sense");
    const std::size_t rest = header.name_size + sizeof(Checksum);
    if (file_.rest() < rest) fail("ends inside the frame's name");
    file_.append_to(section_, rest);
    const std::string_view sealed = std::string_view(section_).substr(0, section_.size() - sizeof(Checksum));
    if (take<Checksum>(section_, sealed.size()) != checksum(sealed))
      fail("the frame's checksum does not fit");
    MapFrame frame{std::string(sealed.substr(sizeof(FrameHeader))), {}};
    if (header.has_origin != 0) frame.origin = {header.origin[0], header.origin[1], header.origin[2]};
    if (frame.name.empty() || (frame.origin && !frame.origin->is_sound())) fail("the frame makes no sense");
    return frame;
  }

  void read_block(Octree& octree) {
    if (file_.rest() < sizeof(BlockHeader)) fail_in_block(file_.position(), "the file ends before it");
    next(sizeof(BlockHeader));
    const auto block = take<BlockHeader>(section_, 0);
    if (block.leaves > VoxelKey::kVoxelsPerBlock || block.payload_size != block.leaves * sizeof(Record))
      fail_in_block(offset_, "its size makes no sense");
    if (file_.rest() < block.payload_size + sizeof(Checksum))
      fail_in_block(offset_, "the file ends inside it");
    file_.append_to(section_, block.payload_size + sizeof(Checksum));
    const std::size_t size = sizeof(BlockHeader) + block.payload_size;
    if (take<Checksum>(section_, size) != checksum(std::string_view(section_).substr(0, size))) {
      fail_in_block(offset_, "its checksum does not fit");
    }
    const bool ascends = block_ == 0 || block.key > last_block_key_;
    if (!ascends || !VoxelKey::is_block(block.key) || block.leaves == 0) {
      fail_in_block(offset_, "its key or number of leaves makes no sense");
    }
    last_block_key_ = block.key;
    read_leaves(octree, block);
  }

  void read_leaves(Octree& octree, const BlockHeader& block) const {
    std::int64_t last_key = -1;
    const VoxelKey first = VoxelKey::first_of_block(block.key);
    BrickReader brick(octree);
    for (std::size_t i = 0; i < block.leaves; ++i) {
      const std::size_t at = sizeof(BlockHeader) + i * sizeof(Record);
      const auto record = take<Record>(section_, at);
      const Leaf leaf = to_leaf(record);
      if (record.key_in_block <= last_key || record.key_in_block >= VoxelKey::kVoxelsPerBlock ||
          !is_sound(leaf)) {
        fail_in_block(offset_ + at, "leaf " + std::to_string(i) + " makes no sense");
      }
      last_key = record.key_in_block;
      brick.add(first.with_voxel_in_block(record.key_in_block), leaf);
    }
    brick.finish();
  }

  InputStream file_;
  std::string section_;       ///< in hand
  std::uint64_t offset_ = 0;  ///< [bytes] of it in the file
  std::uint64_t block_ = 0;
  std::uint64_t last_block_key_ = 0;
  Header header_;  // last, because reading it needs the others
};

}  // namespace

void save_map(const std::filesystem::path& path, const Octree& octree) {
  AtomicFile file(path);
  const MapFrame& frame = octree.frame();
  if (frame.name.empty() || frame.name.size() > kLongestFrameName ||
      (frame.origin && !frame.origin->is_sound()))
    throw FileError(path, "not saved: its frame has no name, or its origin is no place on earth");
  const Header header = header_of(octree);
  file.write(bytes_of(header));
  if (header.format != kFormatWithoutFrame) file.write(bytes_of_frame(frame));
  BlockWriter writer(file);
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!is_sound(leaf)) {
      throw FileError(path,
                      "not saved: leaf " + std::to_string(key.bits()) + " holds a value that is not finite");
    }
    writer.add(key, to_record(key, leaf));
  });
  writer.flush();
  file.write(kEndMark);
  file.commit();
}

Octree load_map(const std::filesystem::path& path) { return MapReader(path).read(); }

}  // namespace evermap
