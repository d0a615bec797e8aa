// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <systemd/sd-daemon.h>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <spdlog/spdlog.h>

#include "command_line.hpp"
#include "options.hpp"
#include "ros_options.hpp"
#include "run.hpp"
#include "verbs.hpp"
#include "web_options.hpp"
#include <evermap/history/map_store.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/ros/map_server.hpp>
#include <evermap/web/live_page.hpp>

namespace evermap {
namespace {

struct ServeOptions {
  std::filesystem::path map;
  ServerOptions server;
  std::optional<Pose> T_map_base_initial;
  bool is_localizing_only = false;
  PageOptions page;
  bool has_page = true;
  int threads = 0;      ///< 0: one per core
  double patience = 0;  ///< [s]
  ParameterOptions parameters;
};

/// Where the robot was last, for the next start: beside the map.
std::filesystem::path last_pose_of(const std::filesystem::path& map) { return map.string() + ".pose"; }

std::optional<Pose> read_last_pose(const std::filesystem::path& map) {
  std::error_code error;
  if (!std::filesystem::exists(last_pose_of(map), error)) return std::nullopt;
  return read_poses(last_pose_of(map)).poses.back().T_map_sensor;
}

/// The robot, and who looks at it in a browser.
class Watch {
 public:
  Watch(const ServeOptions& options, const MapServer& server) {
    if (!options.has_page) return;
    try {
      page_ = std::make_unique<LivePage>(
          options.map, server.map(), web_options_of(options.page),
          [this](const std::string& command, std::function<void(std::string)> reply) {
            const std::lock_guard<std::mutex> lock(mutex_);
            commands_.push_back({command, std::move(reply)});
          });
      print_address(page_->server());
    } catch (const WebError& error) {  // a robot needs its map more than a page
      spdlog::warn("{}; goes on without the page", error.what());
    }
  }

  void follow(MapServer& server, const std::optional<ScanResult>& result) {
    if (!page_) return;
    for (Command& command : take_commands()) server.command(command.text, std::move(command.reply));
    const Clock::time_point now = Clock::now();
    if (!result && now - told_ < kPause) return;
    told_ = now;
    tell(server, result);
    if (!page_->is_watched()) return;
    if (result && result->is_believed()) page_->show_scan(server.p_sensor_of_last(), result->T_map_sensor);
    if (now - shown_ < kShow || !page_->is_ready()) return;
    shown_ = now;
    page_->show(server.map());
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Command {
    std::string text;
    std::function<void(std::string)> reply;
  };
  static constexpr std::chrono::milliseconds kPause{500};  ///< between words without a scan
  static constexpr std::chrono::milliseconds kShow{100};   ///< between maps that are compared

  std::vector<Command> take_commands() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(commands_, {});
  }

  void tell(const MapServer& server, const std::optional<ScanResult>& result) {
    if (result)
      last_ = {result->time, std::string(to_string(result->state)), 0, "", result->is_believed(), {}, {}};
    const Diagnosis diagnosis = server.diagnosis();
    last_.level = diagnosis.level;
    last_.message = diagnosis.message;
    last_.values = diagnosis.values;
    last_.T_map_base = server.base_pose();
    if (!result && diagnosis.level != Diagnosis::kOk) last_.is_believed = false;
    page_->tell(last_);
  }

  RobotStatus last_{0, "waiting", 1, "", false, {}, {}};
  std::mutex mutex_;
  std::vector<Command> commands_;
  Clock::time_point told_;
  Clock::time_point shown_;
  std::unique_ptr<LivePage> page_;
};

void serve(const ServeOptions& options) {
  catch_stop_signals();
  const Parameters parameters = parameters_of(options.parameters);
  MapStore store(options.map, options.patience);
  Octree map = load_start(options.map, store);
  if (map.empty()) throw std::runtime_error(options.map.string() + " has no leaves to localize in");
  ServerOptions server_options = options.server;
  const std::optional<Pose> last = options.T_map_base_initial ? std::nullopt : read_last_pose(options.map);
  server_options.T_map_base_initial = options.T_map_base_initial.value_or(last.value_or(Pose{}));
  server_options.last_pose = last_pose_of(options.map);
  if (options.is_localizing_only) server_options.mode = MapMode::kLocalization;
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(thread_count(options.threads)));
  MapServer server(store, std::move(map), parameters, cause_of("serve", server_options.points, parameters),
                   server_options);
  fmt::print("serves {} in ROS domain {}: clouds from {}, the robot's place on /tf and /{}/pose{}\n",
             options.map.string(), server_options.domain, server_options.points, server_options.name,
             last ? "; it begins where the robot was last" : "");
  std::fflush(stdout);
  Watch watch(options, server);
  sd_notify(0, "READY=1");
  TrackingState state = TrackingState::kStarting;
  while (stop_signal() == 0) {
    constexpr double kStep = 0.1;  // [s] to look for a signal
    const std::optional<ScanResult> result = server.step(kStep);
    sd_notify(0, "WATCHDOG=1");
    watch.follow(server, result);
    if (!result || result->state == state) continue;
    state = result->state;
    sd_notifyf(0, "STATUS=%s", std::string(to_string(state)).c_str());
    spdlog::warn("{:.3f} s: {}{}{}", result->time, to_string(state),
                 result->is_believed() ? "" : ": the scan ", to_string(result->reject_reason));
  }
  sd_notify(0, "STOPPING=1");
  server.finish(is_large(server.map()));
  const ServerCounts& counts = server.counts();
  fmt::print("clouds   {} used, {} believed; {} too old when their turn came, {} damaged\n", counts.used,
             counts.believed, counts.stale, counts.damaged);
  throw Interrupted(stop_signal());
}

}  // namespace

void add_serve(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("serve", "Be the map keeper of a robot that speaks ROS 2");
  const auto options = std::make_shared<ServeOptions>();
  verb->add_option("MAP.evm", options->map, "Map to localize in and to keep up to date")->required();
  add_domain_options(*verb, options->server.domain, options->server.is_local);
  verb->add_option("--points", options->server.points, "Topic of the clouds (sensor_msgs/PointCloud2)")
      ->type_name("TOPIC")
      ->capture_default_str();
  verb->add_option("--odometry", options->server.odometry,
                   "Topic of the odometry, where /tf does not tell it")
      ->type_name("TOPIC")
      ->capture_default_str();
  verb->add_option("--imu", options->server.imu,
                   "Topic of a gyroscope (sensor_msgs/Imu), of use without odometry")
      ->type_name("TOPIC")
      ->capture_default_str();
  verb->add_option("--odom-frame", options->server.odom_frame, "Frame of the odometry in /tf")
      ->type_name("FRAME")
      ->capture_default_str();
  verb->add_option("--base-frame", options->server.base_frame, "Frame of the robot, whose pose is told")
      ->type_name("FRAME")
      ->capture_default_str();
  verb->add_option("--name", options->server.name, "Name of the node: its own topics are below /NAME/")
      ->type_name("NAME")
      ->capture_default_str();
  add_pose_option(*verb, "--initial-pose", "Pose of the base at the first cloud, within 1 m and 10 degrees",
                  [options](const Pose& T_map_base) { options->T_map_base_initial = T_map_base; })
      ->default_str("where the robot was last, or the map's origin");
  verb->add_flag("--no-maintain", options->is_localizing_only, "Leave the map as it is");
  verb->add_option("--save-every", options->server.save_period, "How often a version of the map is kept")
      ->check(CLI::PositiveNumber)
      ->type_name("S")
      ->capture_default_str();
  add_page_options(*verb, options->page);
  verb->add_flag("!--no-page", options->has_page, "Serve no page");
  add_sync_option(*verb, options->server.journal);
  add_threads_option(*verb, options->threads);
  add_mode_option(*verb, options->parameters);
  add_range_options(*verb, options->parameters);
  add_config_option(*verb, options->parameters);
  add_wait_option(*verb, options->patience);
  verb->callback([options] { serve(*options); });
}

}  // namespace evermap
