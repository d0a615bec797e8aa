// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "plot.hpp"

#include <cmath>
#include <cstdlib>
#include <regex>

#include "files/file_fixture.hpp"
#include "gnuplot_script.hpp"

namespace evermap {
namespace {

Plot two_lines() {
  Plot plot;
  plot.title = "Time per scan";
  plot.x = {"leaf edge [m]"};
  plot.y = {"CPU time [ms]"};
  plot.x.is_logarithmic = plot.y.is_logarithmic = true;
  plot.x.tics = {0.1, 0.2, 0.4};
  plot.series.push_back({"OctoMap", {0.1, 0.2, 0.4}, {900, 300, 100}, {800, 250, 90}, {990, 350, 120}});
  plot.series.push_back({"evermap", {0.1, 0.2, 0.4}, {90, 30, 10}, {}, {}});
  return plot;
}

Plot two_bars() {
  Plot plot;
  plot.title = "Kept and erased";
  plot.y = {"share"};
  plot.groups = {"static kept", "50 % of movers"};
  plot.series.push_back({"OctoMap", {}, {0.5, 0.9}, {}, {}});
  plot.series.push_back({"evermap", {}, {0.99, std::nan("")}, {0.98, 0.7}, {1.0, 0.8}});
  return plot;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t number = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++number;
  return number;
}

/// The words that an SVG drawing shows.
std::string shown(const std::string& svg) {
  std::string text = std::regex_replace(svg, std::regex("<[^>]*>"), "");
  const std::pair<const char*, const char*> names[] = {
      {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&amp;", "&"}};
  for (const auto& [name, character] : names) text = std::regex_replace(text, std::regex(name), character);
  return text;
}

class PlotTest : public FileTest {
 protected:
  std::string svg_of(const std::vector<Plot>& panels) const {
    write_plot(path("plot"), panels);
    return content(path("plot.svg"));
  }
};

TEST_F(PlotTest, WritesADrawingAPictureAndTheData) {
  write_plot(path("plot"), two_lines());
  EXPECT_EQ(content(path("plot.png")).substr(0, 8), "\x89PNG\r\n\x1a\n");
  const std::string svg = content(path("plot.svg"));
  EXPECT_TRUE(svg.starts_with("<?xml"));
  EXPECT_TRUE(svg.ends_with("</svg>\n\n")) << "it is whole";
  for (const char* text : {"Time per scan", "leaf edge [m]", "CPU time [ms]", "OctoMap", "evermap", "0.4"}) {
    EXPECT_NE(shown(svg).find(text), std::string::npos) << text;
  }
  EXPECT_EQ(content(path("plot.csv")),
            "panel,series,x,y,low,high\n"
            "Time per scan,OctoMap,0.1,900,800,990\n"
            "Time per scan,OctoMap,0.2,300,250,350\n"
            "Time per scan,OctoMap,0.4,100,90,120\n"
            "Time per scan,evermap,0.1,90,,\n"
            "Time per scan,evermap,0.2,30,,\n"
            "Time per scan,evermap,0.4,10,,\n");
}

TEST_F(PlotTest, TheSamePlotGivesTheSameBytes) {
  write_plot(path("first"), {two_lines(), two_bars()});
  write_plot(path("second"), {two_lines(), two_bars()});
  for (const char* extension : {".png", ".svg", ".csv"}) {
    EXPECT_EQ(content(path(std::string("first") + extension)),
              content(path(std::string("second") + extension)));
  }
}

TEST_F(PlotTest, TextIsShownAsItIsWhateverItMeansToGnuplotOrAShell) {
  const std::string victim = path("victim").string();
  const std::string text = "O'Brien's_x^2 {/Bold a} @b ~c 100 % \"d\" \\n `touch " + victim + "` $(touch " +
                           victim + ") <&> \xc2\xb5";
  Plot plot = two_lines();
  plot.title = "";
  plot.x.label = plot.y.label = plot.series[0].name = text;
  plot.shaded = {{0.15, 0.2, text}};
  EXPECT_EQ(count(shown(svg_of({plot})), text), 4);

  Plot bars = two_bars();
  bars.groups[0] = "100 %d_a^b'c";
  EXPECT_NE(shown(svg_of({bars})).find("100 %d_a^b'c"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(victim));
}

TEST_F(PlotTest, ALineBreakInATextIsNoWayToACommand) {
  const std::string victim = path("victim").string();
  Plot plot = two_lines();
  plot.x.label = "a'\nsystem 'touch " + victim + "'\n#";
  plot.series[0].name = "END\nsystem 'touch " + victim + "'\n";
  svg_of({plot});
  EXPECT_FALSE(std::filesystem::exists(victim));
  EXPECT_EQ(gnuplot_quoted("a'\n'b"), "'a'' ''b'");
}

TEST_F(PlotTest, LongTitlesAndGroupsAreBrokenAtBlanks) {
  Plot plot = two_bars();
  plot.title =
      "A title that goes on and on, far beyond the frame of a panel that is one of three side by side";
  const std::string text = shown(svg_of({plot, plot, plot}));
  EXPECT_EQ(text.find(plot.title), std::string::npos);
  for (const char* word : {"A title that goes", "side by side"}) EXPECT_EQ(count(text, word), 3) << word;
}

TEST_F(PlotTest, PanelsShareOneLegend) {
  const std::string text = shown(svg_of({two_lines(), two_bars()}));
  EXPECT_EQ(count(text, "OctoMap"), 1);
  EXPECT_EQ(count(text, "evermap"), 1);
  Plot nameless = two_lines();
  for (Series& series : nameless.series) series.name.clear();
  EXPECT_EQ(shown(svg_of({nameless})).find("OctoMap"), std::string::npos);
}

TEST_F(PlotTest, AStyleIsTheSameInEveryPlot) {
  Plot plot = two_lines();
  const std::string both = svg_of({plot});
  plot.series.erase(plot.series.begin());
  plot.series[0].style = 1;
  const std::string one = svg_of({plot});
  const std::string orange = "rgb(213,  94,   0)";
  EXPECT_NE(both.find(orange), std::string::npos);
  EXPECT_NE(one.find(orange), std::string::npos);
  EXPECT_EQ(one.find("rgb(  0, 114, 178)"), std::string::npos);
}

TEST_F(PlotTest, AMissingValueLeavesAGap) {
  const std::string script = gnuplot_script({two_bars()});
  EXPECT_NE(script.find("\n1.2 NaN NaN NaN "), std::string::npos) << script.substr(0, 600);
  EXPECT_NE(script.find("\n0.2 0.99 0.98 1 "), std::string::npos);
  svg_of({two_bars()});
  EXPECT_NE(content(path("plot.csv")).find("evermap,50 % of movers,nan,0.7,0.8\n"), std::string::npos);
}

TEST_F(PlotTest, ShadedRangesAndBandsAreDrawn) {
  Plot plot = two_lines();
  const std::string plain = svg_of({plot});
  plot.shaded = {{0.15, 0.3, "cars moved"}};
  plot.series[0].spread = Series::Spread::kBand;
  const std::string svg = svg_of({plot});
  EXPECT_EQ(plain.find("228, 228, 228"), std::string::npos);
  EXPECT_NE(svg.find("228, 228, 228"), std::string::npos);
  EXPECT_NE(shown(svg).find("cars moved"), std::string::npos);
  EXPECT_EQ(plain.find("fill-opacity = '0.20"), std::string::npos);
  EXPECT_NE(svg.find("fill-opacity"), std::string::npos);
}

TEST_F(PlotTest, CsvQuotesWhatNeedsIt) {
  Plot plot = two_lines();
  plot.series = {{"a, \"b\"", {1}, {2}, {}, {}}};
  write_plot(path("plot"), plot);
  EXPECT_EQ(content(path("plot.csv")), "panel,series,x,y,low,high\nTime per scan,\"a, \"\"b\"\"\",1,2,,\n");
}

TEST_F(PlotTest, WhatDoesNotFitTogetherIsAnError) {
  const auto refused = [&](const Plot& plot, const std::string& reason) {
    try {
      write_plot(path("plot"), plot);
      ADD_FAILURE() << reason;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(plot.title), std::string::npos) << error.what();
    }
    EXPECT_FALSE(std::filesystem::exists(path("plot.csv")));
  };
  Plot plot = two_lines();
  plot.series[0].y.pop_back();
  refused(plot, "\"OctoMap\"");
  plot = two_lines();
  plot.series[0].low.pop_back();
  refused(plot, "\"OctoMap\"");
  plot = two_lines();
  plot.series[0].high.clear();
  refused(plot, "\"OctoMap\"");
  plot = two_bars();
  plot.groups.pop_back();
  refused(plot, "\"OctoMap\"");
  plot = two_lines();
  for (Series& series : plot.series) series.y.assign(3, std::nan(""));
  refused(plot, "no value");
  for (Series& series : plot.series) series.y.assign(3, 0);  // the axis is logarithmic
  refused(plot, "no value");
  EXPECT_THROW(write_plot(path("plot"), std::vector<Plot>{}), std::invalid_argument);
}

TEST_F(PlotTest, AMissingGnuplotIsOneClearError) {
  const std::string search_path = std::getenv("PATH");
  ::setenv("PATH", path("").c_str(), 1);
  std::string message;
  try {
    write_plot(path("plot"), two_lines());
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  ::setenv("PATH", search_path.c_str(), 1);
  EXPECT_NE(message.find("gnuplot-nox"), std::string::npos) << message;
  EXPECT_FALSE(std::filesystem::exists(path("plot.csv")));
}

TEST_F(PlotTest, WhatGnuplotSaysIsTheError) {
  make("gnuplot", "#!/bin/sh\necho 'the roof is on fire' >&2\nexit 3\n");
  std::filesystem::permissions(path("gnuplot"), std::filesystem::perms::owner_all);
  const std::string search_path = std::getenv("PATH");
  ::setenv("PATH", (path("").string() + ":" + search_path).c_str(), 1);
  std::string message;
  try {
    write_plot(path("plot"), two_lines());
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  ::setenv("PATH", search_path.c_str(), 1);
  EXPECT_NE(message.find("the roof is on fire"), std::string::npos) << message;
}

TEST_F(PlotTest, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(write_plot(path("nowhere/plot"), two_lines()), FileError);
}

}  // namespace
}  // namespace evermap
