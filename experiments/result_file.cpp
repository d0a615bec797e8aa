// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/result_file.hpp"

#include <fmt/format.h>

#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
namespace {

/// All figures of a row of metrics.
std::string csv_rows(const std::string& unit, const std::string& mapper, const Json& metrics) {
  std::string scan;
  for (const char* along : {"scan", "session"}) {
    if (metrics.contains(along)) scan = metrics[along].dump();
  }
  std::string text;
  for (const auto& [metric, value] : metrics.items()) {
    if (value.is_number() && metric != "scan" && metric != "session") {
      text += fmt::format("{},\"{}\",{},\"{}\",{}\n", unit, mapper, scan, metric, value.dump());
    }
  }
  return text;
}

}  // namespace

Json to_json(const Experiment& experiment, const std::vector<Json>& results) {
  Json units = Json::object();
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Unit& unit = experiment.units[i];
    units[unit.name] = {{"title", unit.title}, {"settings", unit.settings}, {"result", results[i]}};
  }
  return units;
}

Json without_views(Json units) {
  for (auto& unit : units) {
    if (!unit["result"].contains("mappers")) continue;
    for (Json& mapper : unit["result"]["mappers"]) mapper.erase("view");
  }
  return units;
}

std::string to_csv(const Json& units) {
  std::string text = "unit,mapper,scan,metric,value\n";
  for (const auto& [name, unit] : units.items()) {
    const Json& result = unit["result"];
    if (!result.contains("mappers")) {  // of variants of one mapper
      for (const auto& [variant, metrics] : result.items()) text += csv_rows(name, variant, metrics);
      continue;
    }
    for (const Json& mapper : result["mappers"]) {
      for (const Json& row : mapper.value("rows", Json::array())) text += csv_rows(name, mapper["name"], row);
      text += csv_rows(name, mapper["name"], mapper.value("end", mapper));
    }
  }
  return text;
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

}  // namespace evermap
