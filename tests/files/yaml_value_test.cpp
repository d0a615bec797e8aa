// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "files/file_fixture.hpp"
#include <evermap/files/detail/yaml_value.hpp>

namespace evermap {
namespace {

YamlValue parse(const std::string& text) { return YamlValue::parse("a.yaml", text); }

/// The error at this line, which `read` throws when it is given the map of `text`.
template <class Read>
void expect_refused(const std::string& text, std::uint64_t line, std::string_view message, Read read) {
  expect_at_line(file_error("a.yaml", message, [&] { read(parse(text).map()); }), line);
}

TEST(YamlValue, ReadsEveryKindOfValue) {
  const YamlMap map = parse(
                          "number: -1.5e1\nplus: +2\nwhole: 010\nnatural: 18446744073709551615\nyes: true\n"
                          "text: 'two words'\nlist: [1, 2, 3]\nnested:\n  key: 4\nnothing:\nnull_too: ~\n")
                          .map();
  EXPECT_EQ(map.number("number", Limits::any()), -15);
  EXPECT_EQ(map.number("plus", Limits::any()), 2);
  EXPECT_EQ(map.number("absent", Limits::any(), 7), 7);
  EXPECT_EQ(map.get("whole").whole(0, 99), 10);
  EXPECT_EQ(map.get("natural").natural(), 18446744073709551615U);
  EXPECT_TRUE(map.get("yes").truth());
  EXPECT_EQ(map.get("text").text(), "two words");
  EXPECT_EQ(map.get("list").vector3(Limits::any()), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(map.get("list").list().at(2).number(Limits::any()), 3);
  EXPECT_EQ(map.section("nested").number("key", Limits::any()), 4);
  EXPECT_TRUE(map.section("absent").values().empty());
  EXPECT_FALSE(map.find("nothing"));
  EXPECT_FALSE(map.find("null_too"));
  EXPECT_EQ(map.get("nested").line(), 8);
  map.refuse_unknown();
}

TEST(YamlValue, ReadsNamesOfValues) {
  constexpr std::array kNames = {std::pair(3, "three"), std::pair(4, "four")};
  EXPECT_EQ(parse("a: four").map().get("a").one_of<int>(kNames), 4);
  expect_refused("a: five", 1, "a needs one of three four, not 'five'",
                 [&](const YamlMap& map) { map.get("a").one_of<int>(kNames); });
}

TEST(YamlValue, NothingButCommentsIsAMapWithoutValues) {
  EXPECT_TRUE(parse("# nothing\n").map().values().empty());
  EXPECT_TRUE(parse("").map().values().empty());
}

TEST(YamlValue, NamesTheLineOfAValueOfAnotherKind) {
  const auto refused = [](const std::string& value, std::string_view message, auto read) {
    expect_refused("first: 1\na: " + value + "\n", 2, message,
                   [&](const YamlMap& map) { read(map.get("a")); });
  };
  const auto number = [](const YamlValue& value) { value.number({0, 1}); };
  for (const char* value : {"2", "-0.1", ".nan", ".inf", "nan", "1 2", "x", "0x1"}) {
    refused(value, "a needs a number from 0 to 1, not '" + std::string(value) + "'", number);
  }
  refused("[1]", "a needs a number from 0 to 1", number);
  refused("-1", "a needs a number above 0", [](const YamlValue& v) { v.number(Limits::positive()); });
  refused("-1", "at least 0", [](const YamlValue& v) { v.number(Limits::not_negative()); });
  for (const char* value : {"1.5", "1e0", "x", "3", "99999999999999999999", "+-1"}) {
    refused(value, "a whole number from 0 to 2", [](const YamlValue& v) { v.whole(0, 2); });
  }
  for (const char* value : {"-1", "1.0", "18446744073709551616"}) {
    refused(value, "a whole number of at least 0", [](const YamlValue& v) { v.natural(); });
  }
  for (const char* value : {"2", "maybe", "[true]"}) {
    refused(value, "true or false", [](const YamlValue& v) { v.truth(); });
  }
  refused("''", "a word", [](const YamlValue& v) { v.text(); });
  refused("1", "a list", [](const YamlValue& v) { v.list(); });
  refused("[1, 2]", "a list of 3 numbers", [](const YamlValue& v) { v.vector3(Limits::any()); });
  refused("1", "a list of `key: value`", [](const YamlValue& v) { v.map(); });
}

TEST(YamlValue, CutsLongValuesInErrors) {
  try {
    parse("a: " + std::string(20'000'000, 'x')).map().number("a", Limits::any());
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_LT(std::string_view(error.what()).size(), 200U);
  }
  expect_refused(std::string(1000, 'k') + ": 1", 1, "a key must be a name of at most 80",
                 [](const YamlMap&) {});
}

TEST(YamlMap, RefusesWhatStandsTwice) {
  expect_refused("a: 1\nb: 2\na: 3\n", 3, "'a' is set twice, first at line 1", [](const YamlMap&) {});
  expect_refused("s:\n  b: 2\n  b: 3\n", 3, "'b' is set twice, first at line 2", [](const YamlMap&) {});
}

TEST(YamlMap, RefusesWhatNobodyAskedFor) {
  const auto read = [](const YamlMap& map) {
    map.find("a");
    map.find("c");
    map.refuse_unknown();
  };
  expect_refused("a: 1\nb: 2\n", 2, "unknown key 'b'; known here: a c", read);
  expect_refused("b:\n", 1, "unknown key 'b'; see there",
                 [](const YamlMap& map) { map.refuse_unknown("see there"); });
  expect_refused("a: 1\n", 1, "the file lacks b", [](const YamlMap& map) { map.get("b"); });
}

TEST(YamlMap, OverridesKeyByKey) {
  const YamlMap map = parse("a: 1\nb: 2\n").map().overridden(parse("b: 3\nc: 4\n").map());
  EXPECT_EQ(map.number("a", Limits::any()), 1);
  EXPECT_EQ(map.number("b", Limits::any()), 3);
  EXPECT_EQ(map.number("c", Limits::any()), 4);
}

TEST(YamlValue, RefusesWhatIsNoYaml) {
  expect_refused("a: [1\n", 2, "is no YAML", [](const YamlMap&) {});
  expect_refused("- 1\n", 1, "the file needs a list of `key: value`", [](const YamlMap&) {});
  expect_refused("[a]: 1\n", 1, "a key must be a name", [](const YamlMap&) {});
}

TEST(YamlValue, RefusesMoreThanThereIsMemoryFor) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string name = std::to_string(i);
    const std::string alias = "*a" + std::to_string(i - 1);
    std::string list = alias;
    for (int k = 1; k < 10; ++k) list.append(", ").append(alias);
    bomb.append("a").append(name).append(": &a").append(name).append(" [").append(list).append("]\n");
  }
  EXPECT_THROW(parse(bomb), FileError);
  EXPECT_THROW(parse("a: &a [*a]\n"), FileError);
  EXPECT_THROW(parse("a: " + std::string(400, '[')), FileError);
  EXPECT_THROW(parse("a: " + std::string(100, '[') + std::string(100, ']')), FileError);
}

class YamlFileTest : public FileTest {};

TEST_F(YamlFileTest, IsReadFromItsPath) {
  EXPECT_EQ(YamlValue::read(make("a.yaml", "a: 1\n")).map().number("a", Limits::any()), 1);
  const std::filesystem::path bad = make("a.yaml", "a: x\n");
  expect_at_line(file_error(bad, "not 'x'", [&] { YamlValue::read(bad).map().number("a", Limits::any()); }),
                 1);
  file_error(path("none.yaml"), "No such file", [&] { YamlValue::read(path("none.yaml")); });
}

}  // namespace
}  // namespace evermap
