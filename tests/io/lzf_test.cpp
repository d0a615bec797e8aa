// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>
#include <string>

#include <gtest/gtest.h>

#include <evermap/io/detail/lzf.hpp>

namespace evermap {
namespace {

using std::string_literals::operator""s;

std::optional<std::string> decompress(const std::string& compressed, std::size_t size) {
  std::string output(size, '?');
  if (lzf_decompress(compressed, output)) return std::nullopt;
  return output;
}

std::optional<std::size_t> damage(const std::string& compressed, std::size_t size) {
  std::string output(size, '?');
  return lzf_decompress(compressed, output);
}

TEST(Lzf, Literals) { EXPECT_EQ(decompress("\x02"s + "abc", 3), "abc"); }
TEST(Lzf, NothingIsNothing) { EXPECT_EQ(decompress("", 0), ""); }
TEST(Lzf, ShortCopy) { EXPECT_EQ(decompress("\x02"s + "abc" + "\x20\x02"s, 6), "abcabc"); }
TEST(Lzf, OverlappingCopyRepeats) { EXPECT_EQ(decompress("\x01"s + "ab" + "\x60\x01"s, 7), "ababab" + "a"s); }
TEST(Lzf, LongCopy) { EXPECT_EQ(decompress("\x00"s + "a" + "\xE0\xFF\x00"s, 265), std::string(265, 'a')); }

TEST(Lzf, DamageIsNamedByItsOffset) {
  EXPECT_EQ(damage("\x02"s + "ab", 3), 0U) << "literals cut short";
  EXPECT_EQ(damage("\x02"s + "abc", 2), 0U) << "more literals than room";
  EXPECT_EQ(damage("\x02"s + "abc" + "\x20"s, 6), 4U) << "copy cut short";
  EXPECT_EQ(damage("\x02"s + "abc" + "\xE0\x01"s, 16), 4U) << "long copy cut short";
  EXPECT_EQ(damage("\x02"s + "abc" + "\xE0"s, 16), 4U) << "long copy cut shorter";
  EXPECT_EQ(damage("\x02"s + "abc" + "\x20\x03"s, 6), 4U) << "copy from before the start";
  EXPECT_EQ(damage("\x02"s + "abc" + "\x20\x02"s, 5), 4U) << "copy beyond the end";
  EXPECT_EQ(damage("\x02"s + "abc", 4), 4U) << "output not filled";
}

/// A random stream, and what it means in terms of a growing string: the specification, typed naively.
struct Stream {
  std::string compressed;
  std::string meaning;
};

Stream random_stream(std::mt19937& random) {
  Stream stream;
  for (std::size_t i = random() % 30; i > 0; --i) {
    const bool is_literal = stream.meaning.empty() || random() % 2 == 0;
    if (is_literal) {
      const std::size_t length = 1 + random() % 32;
      stream.compressed += static_cast<char>(length - 1);
      for (std::size_t k = 0; k < length; ++k) {
        const char c = static_cast<char>(random() % 256);
        stream.compressed += c;
        stream.meaning += c;
      }
      continue;
    }
    const std::size_t length = random() % 2 == 0 ? 3 + random() % 6 : 9 + random() % 256;
    const std::size_t back = 1 + random() % std::min<std::size_t>(stream.meaning.size(), 8192);
    const std::size_t code = length < 9 ? length - 2 : 7;
    stream.compressed += static_cast<char>(code << 5 | (back - 1) >> 8);
    if (code == 7) stream.compressed += static_cast<char>(length - 9);
    stream.compressed += static_cast<char>((back - 1) & 255);
    for (std::size_t k = 0; k < length; ++k) stream.meaning += stream.meaning[stream.meaning.size() - back];
  }
  return stream;
}

TEST(Lzf, RandomStreamsMeanWhatTheFormatSays) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Stream stream = random_stream(random);
    ASSERT_EQ(decompress(stream.compressed, stream.meaning.size()), stream.meaning);
    ASSERT_LE(stream.meaning.size(), kLzfMaxRatio * stream.compressed.size());
    ASSERT_TRUE(damage(stream.compressed, stream.meaning.size() + 1));
    if (!stream.meaning.empty()) {
      ASSERT_TRUE(damage(stream.compressed, stream.meaning.size() - 1));
    }
  }
}

TEST(Lzf, RandomBytesStayInBounds) {
  std::mt19937 random(2);
  for (int i = 0; i < 20000; ++i) {
    std::string noise(random() % 40, '\0');
    for (char& c : noise) c = static_cast<char>(random() % 256);
    const std::optional<std::size_t> place = damage(noise, random() % 200);
    ASSERT_LE(place.value_or(0), noise.size());
  }
}

}  // namespace
}  // namespace evermap
