// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "html_report.hpp"

#include <cmath>
#include <regex>
#include <set>
#include <stdexcept>

#include "files/file_fixture.hpp"

namespace evermap {
namespace {

using Best = HtmlTable::Best;

const std::string kDrawing =
    "<?xml version='1.0'?>\n<svg xmlns='http://www.w3.org/2000/svg'><defs><circle id='dot' r='1'/></defs>"
    "<use xlink:href='#dot'/><rect fill='url(#dot)'/><text>a &lt; b, id='dot' #dot</text></svg>\n";

/// What is wrong with the nesting of a page's tags; empty when nothing is.
std::string nesting_error(const std::string& html) {
  const std::set<std::string> without_end{"meta", "img", "!DOCTYPE"};
  std::vector<std::string> open;
  const std::regex tag("<(/?)([!a-zA-Z0-9]+)([^>]*)>");
  for (std::sregex_iterator found(html.begin(), html.end(), tag), end; found != end; ++found) {
    const std::string name = (*found)[2];
    const std::string rest = (*found)[3];
    if (without_end.contains(name) || rest.ends_with('/')) continue;
    if ((*found)[1].length() == 0) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> at " + std::to_string(found->position());
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> is open";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class HtmlReportTest : public FileTest {
 protected:
  HtmlReport whole_report() const {
    HtmlReport report("Kept & erased");
    report.heading("Accuracy");
    report.paragraph("What maps keep.");
    report.facts({{"machine", "a < b"}, {"OctoMap", "1.9.7"}});
    report.code("script/paper > out\nls 'out'");
    report.table(table());
    report.figure(make("plot.svg", kDrawing), "A drawing");
    report.figure(make("plot.png", "not really"), "A \"picture\"");
    return report;
  }
  static HtmlTable table() {
    return {"Two maps",
            {{"map"}, {"SA", Best::kHighest}, {"AHD [m]", Best::kLowest, 2}, {"leaves", Best::kNone, 0}},
            {{"static", 1.0, 0.481, 1e6},
             {"OctoMap", 0.4821, 0.479, 2e6},
             {"UFOMap", "not installed", std::nan(""), 0.0}}};
  }
};

TEST_F(HtmlReportTest, IsAWholePage) {
  const std::string html = whole_report().html();
  EXPECT_TRUE(html.starts_with("<!DOCTYPE html>"));
  EXPECT_EQ(nesting_error(html), "");
  EXPECT_TRUE(contains(html, "<title>Kept &amp; erased</title>"));
  EXPECT_TRUE(contains(html, "<h2>Accuracy</h2>"));
  EXPECT_TRUE(contains(html, "<pre>script/paper &gt; out\nls 'out'</pre>"));
  EXPECT_TRUE(contains(html, "<dt>machine</dt><dd>a &lt; b</dd>"));
}

TEST_F(HtmlReportTest, NeedsNothingElse) {
  const std::string html = whole_report().html();
  for (const char* part :
       {"<script", "<link", "@import", "src=\"http", "href=\"http", "href='http", "url(http"}) {
    EXPECT_FALSE(contains(html, part)) << part;
  }
  std::filesystem::remove(path("plot.svg"));
  std::filesystem::remove(path("plot.png"));
  EXPECT_EQ(whole_report().html(), html);
}

TEST_F(HtmlReportTest, AllTextIsShownAsItIs) {
  const std::string text = "</p><script>alert('1')</script>&amp;\"";
  const std::string shown = "&lt;/p&gt;&lt;script&gt;alert('1')&lt;/script&gt;&amp;amp;&quot;";
  HtmlReport report(text);
  report.heading(text);
  report.paragraph(text);
  report.code(text);
  report.facts({{text, text}});
  report.table({text, {{text}}, {{text}}});
  report.figure(make("a.svg", kDrawing), text);
  report.figure(make("a.png", "x"), text);
  const std::string html = report.html();
  EXPECT_FALSE(contains(html, "<script>"));
  std::size_t count = 0;
  for (std::size_t at = html.find(shown); at != std::string::npos; at = html.find(shown, at + 1)) ++count;
  EXPECT_EQ(count, 13) << "title and h1, h2, p, pre, dt, dd, caption, th, td, two captions and an alt";
  EXPECT_EQ(nesting_error(html), "");
}

TEST_F(HtmlReportTest, NumbersStandToTheRightAndTheBestIsMarked) {
  HtmlReport report("");
  report.table(table());
  const std::string html = report.html();
  EXPECT_TRUE(contains(html, "<th>map</th><th class=\"number\">SA</th><th class=\"number\">AHD [m]</th>"));
  EXPECT_TRUE(contains(html,
                       "<tr><td>static</td><td class=\"number best\">1.000</td>"
                       "<td class=\"number best\">0.48</td><td class=\"number\">1000000</td></tr>"))
      << "0.481 looks the same as the best, 0.479";
  EXPECT_TRUE(contains(html,
                       "<tr><td>OctoMap</td><td class=\"number\">0.482</td>"
                       "<td class=\"number best\">0.48</td><td class=\"number\">2000000</td></tr>"));
  EXPECT_TRUE(contains(html,
                       "<tr><td>UFOMap</td><td class=\"number missing\">not installed</td>"
                       "<td class=\"number missing\">\u2013</td><td class=\"number\">0</td></tr>"));
}

TEST_F(HtmlReportTest, TheBestMayBeNegativeOrNoneAtAll) {
  HtmlReport report("");
  report.table(
      {"", {{"a", Best::kHighest, 0}, {"b", Best::kLowest, 0}}, {{-2.0, std::nan("")}, {-1.0, INFINITY}}});
  const std::string html = report.html();
  EXPECT_TRUE(contains(html, "<td class=\"number best\">-1</td>"));
  EXPECT_TRUE(contains(html, "<td class=\"number\">-2</td>"));
  EXPECT_FALSE(contains(html, "missing best"));
}

TEST_F(HtmlReportTest, TheBestMayStandAnywhere) {
  HtmlReport report("");
  report.table(
      {"", {{"a", Best::kHighest, 0}, {"b", Best::kLowest, 0}}, {{1.0, 2.0}, {3.0, 1.0}, {2.0, 3.0}}});
  const std::string row = "<tr><td class=\"number best\">3</td><td class=\"number best\">1</td></tr>";
  EXPECT_TRUE(contains(report.html(), row));
  EXPECT_EQ(report.html().find("number best", report.html().find(row) + row.size()), std::string::npos);
}

TEST_F(HtmlReportTest, ARowOfAnotherLengthIsAnError) {
  HtmlReport report("");
  HtmlTable broken = table();
  broken.rows[1].pop_back();
  EXPECT_THROW(report.table(broken), std::invalid_argument);
}

TEST_F(HtmlReportTest, PicturesAreInBase64) {
  // The test vectors of RFC 4648, and every byte.
  std::string all_bytes;
  for (int i = 0; i < 256; ++i) all_bytes += static_cast<char>(i);
  const std::pair<std::string, std::string> examples[] = {
      {"f", "Zg=="},         {"fo", "Zm8="},         {"foo", "Zm9v"},      {"foob", "Zm9vYg=="},
      {"fooba", "Zm9vYmE="}, {"foobar", "Zm9vYmFy"}, {"\xff\xfe", "//4="}, {"\xfb\xf0", "+/A="}};
  for (const auto& [bytes, text] : examples) {
    HtmlReport report("");
    report.figure(make("a.png", bytes), "");
    EXPECT_TRUE(contains(report.html(), "src=\"data:image/png;base64," + text + "\"")) << text;
  }
  HtmlReport report("");
  report.figure(make("a.png", all_bytes), "");
  EXPECT_TRUE(contains(report.html(), "base64,AAECAwQFBgcICQoLDA0O")) << "zeros are bytes, too";
}

TEST_F(HtmlReportTest, DrawingsKeepTheirNamesApart) {
  HtmlReport report("");
  report.figure(make("a.svg", kDrawing), "");
  report.figure(make("a.svg", kDrawing), "");
  const std::string html = report.html();
  EXPECT_FALSE(contains(html, "<?xml"));
  for (const std::string prefix : {"figure0-", "figure1-"}) {
    EXPECT_TRUE(contains(html, "<circle id='" + prefix + "dot' r='1'/></defs><use xlink:href='#" + prefix +
                                   "dot'/><rect fill='url(#" + prefix +
                                   "dot)'/><text>a &lt; b, id='dot' #dot</text>"))
        << html;
  }
}

TEST_F(HtmlReportTest, APictureThatCannotBeShownIsAnError) {
  HtmlReport report("");
  EXPECT_THROW(report.figure(path("nowhere.svg"), ""), FileError);
  EXPECT_THROW(report.figure(make("empty.png", ""), ""), FileError);
  EXPECT_THROW(report.figure(make("text.svg", "no drawing"), ""), FileError);
  EXPECT_THROW(report.figure(make("plot.gif", "GIF89a"), ""), FileError);
  EXPECT_EQ(report.html(), HtmlReport("").html()) << "nothing of it is left in the page";
}

TEST_F(HtmlReportTest, IsSavedAsItIs) {
  const HtmlReport report = whole_report();
  report.save(path("index.html"));
  EXPECT_EQ(content(path("index.html")), report.html());
  EXPECT_THROW(report.save(path("nowhere/index.html")), FileError);
}

}  // namespace
}  // namespace evermap
