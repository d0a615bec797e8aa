// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <thread>

#include "command_line.hpp"
#include "report.hpp"
#include "run.hpp"
#include "verbs.hpp"
#include "web_options.hpp"
#include <evermap/files/file_error.hpp>
#include <evermap/web/map_page.hpp>

namespace evermap {
namespace {

struct ViewOptions {
  std::filesystem::path map;
  std::string shown = "now";
  PageOptions page;
};

/// The page that a report holds.
WebHandler handler_of_report(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kViewerName;
  std::ifstream file(path, std::ios::binary);
  std::string html{std::istreambuf_iterator<char>(file), {}};
  if (html.empty()) throw FileError(path, "cannot be read; --report of update, localize and diff writes it");
  return [html](const WebRequest& request, const WebRespond& respond) {
    if (request.path != "/") return respond({404, "text/plain", "there is the report alone\n"});
    respond({200, "text/html; charset=utf-8", html});
  };
}

WebHandler handler_of_map(const ViewOptions& options) {
  const auto page = std::make_shared<MapPage>(options.map, options.shown);
  return [page](const WebRequest& request, const WebRespond& respond) { page->respond(request, respond); };
}

void view(const ViewOptions& options) {
  catch_stop_signals();
  std::error_code error;
  const bool is_report = std::filesystem::is_directory(options.shown, error);
  const WebServer server(web_options_of(options.page),
                         is_report ? handler_of_report(options.shown) : handler_of_map(options));
  print_address(server);
  constexpr std::chrono::milliseconds kPause(100);
  while (stop_signal() == 0) std::this_thread::sleep_for(kPause);
  throw Interrupted(stop_signal());
}

}  // namespace

void add_view(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("view", "Show a map, its versions and changes in a browser");
  const auto options = std::make_shared<ViewOptions>();
  verb->add_option("MAP.evm", options->map, "Map to show")->required();
  verb->add_option(
          "WHAT", options->shown,
          "A version, by number or tag; what changed between two, 3..5 or 3..now; or a report's folder")
      ->capture_default_str();
  add_page_options(*verb, options->page);
  verb->callback([options] { view(*options); });
}

}  // namespace evermap
