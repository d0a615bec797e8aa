// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#ifdef EVERMAP_READ_GZIP
#include <zlib.h>

#include "files/file_fixture.hpp"
#include <evermap/files/detail/gzip.hpp>
#include <evermap/files/detail/input_file.hpp>

namespace evermap {
namespace {

std::string gzip(const std::string& content) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY),
            Z_OK);
  std::string compressed(deflateBound(&stream, content.size()), '\0');
  std::string given = content;
  stream.next_in = reinterpret_cast<Bytef*>(given.data());
  stream.avail_in = static_cast<unsigned>(given.size());
  stream.next_out = reinterpret_cast<Bytef*>(compressed.data());
  stream.avail_out = static_cast<unsigned>(compressed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  compressed.resize(stream.total_out);
  deflateEnd(&stream);
  return compressed;
}

class GzipTest : public FileTest {
 protected:
  void expect_refused(const std::string& bytes, std::string_view message) {
    const std::filesystem::path file = make("a.gz", bytes);
    file_error(file, message, [&] { InputFile input(file); });
  }
};

TEST_F(GzipTest, TheNameTells) {
  EXPECT_TRUE(is_gzip("folder/a.bin.gz"));
  EXPECT_FALSE(is_gzip("folder.gz/a.bin"));
  EXPECT_EQ(without_gzip("folder/1.5.bin.gz"), "folder/1.5.bin");
  EXPECT_EQ(without_gzip("folder/1.5.bin"), "folder/1.5.bin");
  EXPECT_EQ(InputFile(make("a", gzip("as it is"))).bytes(), gzip("as it is"));
}

TEST_F(GzipTest, HoldsAllBytes) {
  std::string content(3'000'000, 'x');
  for (std::size_t i = 0; i < content.size(); ++i) content[i] = static_cast<char>((i * i) >> 7);
  EXPECT_TRUE(InputFile(make("a.gz", gzip(content))).bytes() == content);
  EXPECT_EQ(InputFile(make("a.gz", gzip("one ") + gzip("") + gzip("and two"))).bytes(), "one and two");
}

TEST_F(GzipTest, DamageIsFoundWhereverItIs) {
  const std::string whole = gzip("a scan, and another scan, and one scan more");
  for (std::size_t size = 1; size < whole.size(); ++size)
    expect_refused(whole.substr(0, size), "is damaged inside its gzip compression");
  for (std::size_t at = whole.size() - 8; at < whole.size(); ++at) {  // checksum and length
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    expect_refused(damaged, "is damaged inside its gzip compression");
  }
  expect_refused(whole + "more", "is damaged inside its gzip compression");
}

TEST_F(GzipTest, ABombIsRefused) {
  const std::string member = gzip(std::string(1 << 20, '\0'));
  std::string bomb;
  for (int i = 0; i < 300; ++i) bomb += member;
  expect_refused(bomb, "grows more than 64-fold");
}

}  // namespace
}  // namespace evermap
#endif
