// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "files/file_fixture.hpp"
#include <evermap/files/detail/text_lines.hpp>

namespace evermap {
namespace {

TEST(Tokens, AreSeparatedByAnyBlanks) {
  std::string_view text = " \tone  two\r";
  EXPECT_EQ(next_token(text), "one");
  EXPECT_EQ(next_token(text), "two");
  EXPECT_EQ(next_token(text), "");
  EXPECT_EQ(next_token(text), "");
}

TEST(Numbers, AreSpelledAsCProgramsPrintThem) {
  EXPECT_EQ(parse_number("-1.5e3"), -1500.0);
  EXPECT_EQ(parse_number("+.5"), 0.5);
  EXPECT_TRUE(std::isnan(parse_number("-nan").value()));
  EXPECT_EQ(parse_number("inf"), INFINITY);
  for (const char* bad : {"", "+", "-", "+-1", "1x", "x1", "1,5", "0x10", "1 ", "1e", "1e999"}) {
    EXPECT_FALSE(parse_number(bad)) << bad;
  }
  EXPECT_EQ(parse_count("18446744073709551615"), 18446744073709551615U);
  for (const char* bad : {"", "-1", "+1", "1.0", "18446744073709551616"})
    EXPECT_FALSE(parse_count(bad)) << bad;
}

TEST(InQuotes, MakesOneShortPrintableLine) {
  EXPECT_EQ(in_quotes("abc"), "'abc'");
  EXPECT_EQ(in_quotes(std::string_view("a\nb\0\xff", 5)),
            "'a?b?"
            "?'");
  EXPECT_LT(in_quotes(std::string(1000, 'x')).size(), 50U);
}

class TextLinesTest : public FileTest {};

TEST_F(TextLinesTest, CountsLinesAndBytes) {
  const InputFile file(make("a", "one\r\n\n two \nbinary"));
  TextLines lines(file);
  ASSERT_TRUE(lines.next());
  EXPECT_EQ(lines.line(), "one");
  EXPECT_EQ(lines.offset(), 5U);
  ASSERT_TRUE(lines.next_filled());
  EXPECT_EQ(lines.line(), " two ");
  EXPECT_EQ(lines.number(), 3U);
  EXPECT_EQ(lines.remaining(), 6U);
  ASSERT_TRUE(lines.next());
  EXPECT_EQ(lines.line(), "binary");
  EXPECT_EQ(lines.remaining(), 0U);
  EXPECT_FALSE(lines.next());
  EXPECT_FALSE(lines.next_filled());
}

}  // namespace
}  // namespace evermap
