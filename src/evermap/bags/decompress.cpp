// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bzlib.h>
#include <cstdlib>
#include <fstream>
#include <lz4frame.h>
#include <memory>
#include <system_error>
#include <unistd.h>

#include <zstd.h>

#include <evermap/bags/detail/decompress.hpp>
#include <evermap/files/detail/expansion.hpp>
#include <evermap/files/detail/input_file.hpp>

namespace evermap {
namespace {

/// What a step of decompression did.
struct Step {
  std::size_t taken = 0;  ///< [bytes] of what is compressed
  std::size_t given = 0;  ///< [bytes] written
  bool is_end = false;
  bool is_damaged = false;
};

/// Fills `output` with `size` bytes, or says false. `take_step` is given what is left of the compressed bytes
/// and of the room. What a header claims takes memory only as it comes.
template <class TakeStep>
bool fill(std::string_view compressed, std::uint64_t size, std::string& output, TakeStep&& take_step) {
  constexpr std::uint64_t kUsual = 8;           // times as large as compressed; more takes more than one turn
  constexpr std::uint64_t kAtFirst = 1U << 16;  // [bytes] at the least
  output.resize(std::min(size, std::max(kAtFirst, kUsual * compressed.size())));
  for (std::size_t done = 0;;) {
    if (done == output.size() && done < size) output.resize(std::min<std::uint64_t>(size, 2 * done));
    const Step step = take_step(compressed, output.data() + done, output.size() - done);
    if (step.is_damaged) return false;
    compressed.remove_prefix(step.taken);
    done += step.given;
    if (step.is_end) return done == size;
    if (step.taken == 0 && step.given == 0) return false;
  }
}

bool copy(std::string_view stored, std::uint64_t size, std::string& output) {
  if (stored.size() != size) return false;
  output = stored;
  return true;
}

bool from_bz2(std::string_view compressed, std::uint64_t size, std::string& output) {
  bz_stream stream{};
  if (::BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return false;
  const std::unique_ptr<bz_stream, decltype(&::BZ2_bzDecompressEnd)> ended(&stream, ::BZ2_bzDecompressEnd);
  return fill(compressed, size, output, [&](std::string_view rest, char* room, std::size_t room_size) {
    constexpr std::size_t kMost = 1U << 30;  // [bytes] the library counts in 32 bits
    // The library does not change its input, though it does not say so.
    stream.next_in = const_cast<char*>(rest.data());
    stream.avail_in = static_cast<unsigned>(std::min(rest.size(), kMost));
    stream.next_out = room;
    stream.avail_out = static_cast<unsigned>(std::min(room_size, kMost));
    const int result = ::BZ2_bzDecompress(&stream);
    return Step{static_cast<std::size_t>(stream.next_in - rest.data()),
                static_cast<std::size_t>(stream.next_out - room), result == BZ_STREAM_END,
                result != BZ_OK && result != BZ_STREAM_END};
  });
}

bool from_lz4(std::string_view compressed, std::uint64_t size, std::string& output) {
  LZ4F_dctx* created = nullptr;
  if (::LZ4F_isError(::LZ4F_createDecompressionContext(&created, LZ4F_VERSION))) return false;
  const std::unique_ptr<LZ4F_dctx, decltype(&::LZ4F_freeDecompressionContext)> context(
      created, ::LZ4F_freeDecompressionContext);
  return fill(compressed, size, output, [&](std::string_view rest, char* room, std::size_t room_size) {
    Step step{rest.size(), room_size};
    const std::size_t left =
        ::LZ4F_decompress(context.get(), room, &step.given, rest.data(), &step.taken, nullptr);
    step.is_damaged = ::LZ4F_isError(left) != 0;
    step.is_end = left == 0;
    return step;
  });
}

bool from_zstd(std::string_view compressed, std::uint64_t size, std::string& output) {
  const std::unique_ptr<ZSTD_DStream, decltype(&::ZSTD_freeDStream)> stream(::ZSTD_createDStream(),
                                                                            ::ZSTD_freeDStream);
  return fill(compressed, size, output, [&](std::string_view rest, char* room, std::size_t room_size) {
    ZSTD_inBuffer from{rest.data(), rest.size(), 0};
    ZSTD_outBuffer to{room, room_size, 0};
    const std::size_t left = ::ZSTD_decompressStream(stream.get(), &to, &from);
    return Step{from.pos, to.pos, left == 0, ::ZSTD_isError(left) != 0};
  });
}

struct Compression {
  std::string_view name;
  bool (*decompress)(std::string_view compressed, std::uint64_t size, std::string& output);
};
constexpr std::array<Compression, 5> kCompressions = {
    {{"", copy}, {"none", copy}, {"bz2", from_bz2}, {"lz4", from_lz4}, {"zstd", from_zstd}}};

const Compression* compression_of(std::string_view name) {
  const auto* found = std::find_if(kCompressions.begin(), kCompressions.end(),
                                   [&](const Compression& known) { return known.name == name; });
  return found == kCompressions.end() ? nullptr : found;
}

}  // namespace

std::optional<std::string> decompress(std::string_view compression, std::string_view compressed,
                                      std::uint64_t size, std::string& output) {
  const Compression* known = compression_of(compression);
  if (known == nullptr) return "is compressed in an unknown way";
  if (size > greatest_expansion(compressed.size())) {
    return "expands to " + std::to_string(size) + " bytes, more than " + std::to_string(compressed.size()) +
           " compressed bytes may";
  }
  if (!known->decompress(compressed, size, output)) return "holds damaged data";
  return std::nullopt;
}

bool is_zstd(std::string_view bytes) {
  constexpr std::string_view kZstdMagic = "\x28\xB5\x2F\xFD";
  return bytes.starts_with(kZstdMagic);
}

std::optional<std::uint64_t> zstd_size(std::string_view bytes) {
  const unsigned long long size = ::ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
  return size;
}

UncompressedCopy::UncompressedCopy(const std::filesystem::path& compressed) {
  std::string name = (std::filesystem::temp_directory_path() / "evermap-bag-XXXXXX").string();
  const int descriptor = ::mkstemp(name.data());
  if (descriptor < 0) throw FileError(name, "cannot be made to uncompress " + compressed.string());
  ::close(descriptor);
  path_ = name;
  try {
    InputStream input(compressed);
    std::ofstream output(path_, std::ios::binary);
    const std::unique_ptr<ZSTD_DStream, decltype(&::ZSTD_freeDStream)> stream(::ZSTD_createDStream(),
                                                                              ::ZSTD_freeDStream);
    std::string in;
    std::string out(::ZSTD_DStreamOutSize(), '\0');
    std::size_t left = 1;  // 0 at the end of a frame
    while (input.rest() > 0) {
      in.clear();
      input.append_to(in, std::min<std::uint64_t>(input.rest(), ::ZSTD_DStreamInSize()));
      ZSTD_inBuffer from{in.data(), in.size(), 0};
      bool is_full = true;
      while (from.pos < from.size || is_full) {
        ZSTD_outBuffer to{out.data(), out.size(), 0};
        left = ::ZSTD_decompressStream(stream.get(), &to, &from);
        if (::ZSTD_isError(left)) {
          throw FileError::at_byte(compressed, input.position() - from.size + from.pos,
                                   "the compressed data is damaged; copy the file again");
        }
        if (!output.write(out.data(), static_cast<std::streamsize>(to.pos)))
          throw FileError(path_, "cannot hold what " + compressed.string() + " holds; is the device full?");
        is_full = to.pos == to.size;
      }
    }
    if (left != 0) throw FileError(compressed, "ends inside its compressed data; copy the file again");
    if (!output.flush()) throw FileError(path_, "cannot be written; is the device full?");
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
    throw;
  }
}

UncompressedCopy::~UncompressedCopy() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace evermap
