// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>

#include <nlohmann/json.hpp>

#include <evermap/files/detail/background.hpp>
#include <evermap/web/live_page.hpp>

namespace evermap {
namespace {

using Json = nlohmann::ordered_json;

std::string to_json(const RobotStatus& status) {
  const Eigen::Vector3d& t = status.T_map_base.translation;
  const Eigen::Quaterniond q(status.T_map_base.rotation);
  Json values = Json::object();
  for (const auto& [key, value] : status.values) values[key] = value;
  const Json json = {{"time", status.time},
                     {"state", status.state},
                     {"level", status.level},
                     {"message", status.message},
                     {"believed", status.is_believed},
                     {"pose", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}},
                     {"values", values}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace

LivePage::LivePage(const std::filesystem::path& map, const Octree& begun, const WebOptions& options,
                   MapPage::TakeCommand commands)
    : page_(map, begun), server_(options, [this](const WebRequest& request, const WebRespond& respond) {
        page_.respond(request, respond);
      }) {
  page_.set_commands(std::move(commands));
}

LivePage::~LivePage() {
  if (showing_.valid()) showing_.wait();
}

void LivePage::tell(const RobotStatus& status) {
  std::string json = to_json(status);
  server_.send_text("{\"status\":" + json + "}");
  page_.set_status(std::move(json));
}

void LivePage::show_scan(std::span<const Eigen::Vector3d> p_sensor, const Pose& T_map_sensor) {
  constexpr std::size_t kMost = 20'000;
  const std::size_t step = 1 + p_sensor.size() / kMost;
  std::string bytes;
  for (const double x : T_map_sensor.translation) append(bytes, x);
  for (std::size_t i = 0; i < p_sensor.size(); i += step) {
    const Eigen::Vector3f p = (T_map_sensor.rotation * p_sensor[i]).cast<float>();
    for (const float x : p) append(bytes, x);
  }
  server_.send_binary(std::move(bytes));
}

bool LivePage::is_ready() {
  return !showing_.valid() || showing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void LivePage::show(Octree map) {
  showing_ = in_background([this, reached = std::move(map)] {
    std::string changed = page_.show(reached);
    if (!changed.empty()) server_.send_text(std::move(changed));
  });
}

}  // namespace evermap
