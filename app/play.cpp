// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "command_line.hpp"
#include "options.hpp"
#include "posed_scans.hpp"
#include "progress_bar.hpp"
#include "ros_options.hpp"
#include "run.hpp"
#include "verbs.hpp"
#include <evermap/bags/detail/bag_reader.hpp>
#include <evermap/bags/detail/messages.hpp>
#include <evermap/bags/detail/scan_bag.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/ros/scan_publisher.hpp>

namespace evermap {
namespace {

struct PlayOptions {
  std::filesystem::path recording;
  ScanOptions reading;
  unsigned domain = 0;
  bool is_local = false;
  std::string points = "/points";
  std::string odometry_topic = "/odom";
  std::string odometry;  ///< poses of the sensor
  double speed = 1;
  double scan_rate = 10;  ///< [Hz] of scans without times
  double wait = 10;       ///< [s] for a listener
};

/// Lets the recording's time pass as fast as was asked for.
class Pace {
 public:
  Pace(ScanPublisher& publisher, double speed) : publisher_(publisher), speed_(speed) {}

  /// Returns when `time` [s] of the recording is reached, and tells it to /clock.
  void reach(double time) {
    using Clock = std::chrono::steady_clock;
    if (!std::exchange(has_begun_, true)) {
      first_ = time;
      begin_ = Clock::now();
    }
    std::this_thread::sleep_until(begin_ + std::chrono::duration_cast<Clock::duration>(
                                               std::chrono::duration<double>((time - first_) / speed_)));
    publisher_.send_clock(time);
  }

 private:
  ScanPublisher& publisher_;
  double speed_;
  bool has_begun_ = false;
  double first_ = 0;  ///< [s]
  std::chrono::steady_clock::time_point begin_;
};

void wait_for_listener(const ScanPublisher& publisher, double seconds) {
  constexpr double kStep = 0.05;  // [s]
  for (double waited = 0; publisher.listeners() == 0 && stop_signal() == 0; waited += kStep) {
    if (waited > seconds)
      throw std::runtime_error(fmt::format("nobody listened to the clouds for {} s", seconds));
    std::this_thread::sleep_for(std::chrono::duration<double>(kStep));
  }
}

/// Clouds of files, with odometry from poses of the sensor where they are given.
std::size_t play_scans(const PlayOptions& options, ScanPublisher& publisher) {
  const std::string frame = "lidar";
  ScanOptions reading = options.reading;
  ScanPoses odometry(options.odometry, options.recording, reading);
  const std::unique_ptr<ScanSource> scans = open_scans(options.recording, reading);
  Pace pace(publisher, options.speed);
  const ProgressBar bar(scans->size());
  std::size_t count = 0;
  while (std::optional<Scan> scan = stop_signal() == 0 ? scans->next() : std::nullopt) {
    if (count == 0) odometry.match(*scans, options.recording, *scan);
    const double by_count = static_cast<double>(scans->index() + 1) / options.scan_rate;
    scan->time = scan->time.value_or(odometry.time(*scans).value_or(by_count));
    pace.reach(*scan->time);
    publisher.send_cloud(*scan, frame);
    if (const std::optional<Pose> T_odom_sensor = odometry.end_of(*scan, *scans)) {
      constexpr double kAfter = 1e-3;  // [s] odometry is known beyond the scan's end
      publisher.send_transforms({{*scan->time, "odom", frame, *T_odom_sensor},
                                 {*scan->time + kAfter, "odom", frame, *T_odom_sensor}},
                                false);
    }
    bar.show(++count);
  }
  return count;
}

/// A bag's clouds, transforms and odometry.
std::size_t play_bag(const PlayOptions& options, ScanPublisher& publisher) {
  const std::unique_ptr<BagReader> bag = open_bag(options.recording);
  const std::vector<BagTopic>& topics = bag->topics();
  const std::size_t clouds = find_cloud_topic(*bag, options.reading.topic);
  Pace pace(publisher, options.speed);
  const ProgressBar bar(topics[clouds].messages);
  std::size_t count = 0;
  while (const std::optional<BagMessage> message = stop_signal() == 0 ? bag->next() : std::nullopt) {
    const BagTopic& topic = topics[message->topic];
    if (message->topic == clouds) {
      const CloudMessage cloud = read_cloud_message(topic, message->bytes, bag->path());
      pace.reach(message->time);
      publisher.send_cloud(cloud.scan, cloud.frame);
      bar.show(++count);
    } else if (kind_of(topic.type) == MessageKind::kTransforms) {
      pace.reach(message->time);
      publisher.send_transforms(read_transforms(topic, message->bytes), topic.name.ends_with("tf_static"));
    } else if (topic.type == "nav_msgs/Odometry") {
      pace.reach(message->time);
      for (const StampedTransform& pose : read_transforms(topic, message->bytes))
        publisher.send_odometry(pose);
    }
  }
  if (!bag->damage().empty()) throw FileError(bag->path(), bag->damage());
  return count;
}

void play(const PlayOptions& options) {
  ScanPublisher publisher(options.domain, options.is_local, options.points, options.odometry_topic);
  catch_stop_signals();
  wait_for_listener(publisher, options.wait);
  const std::size_t clouds =
      is_bag(options.recording) ? play_bag(options, publisher) : play_scans(options, publisher);
  fmt::print("played   {} clouds of {}\n", clouds, options.recording.string());
  if (stop_signal() != 0) throw Interrupted(stop_signal());
}

}  // namespace

void add_play(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("play", "Publish a recording on the topics of ROS 2, as a robot would");
  const auto options = std::make_shared<PlayOptions>();
  add_scans_options(*verb, options->recording, options->reading);
  add_domain_options(*verb, options->domain, options->is_local);
  verb->add_option("--points", options->points, "Topic to send clouds on")
      ->type_name("TOPIC")
      ->capture_default_str();
  verb->add_option("--odometry-topic", options->odometry_topic, "Topic to send a bag's odometry on")
      ->type_name("TOPIC")
      ->capture_default_str();
  verb->add_option(
          "--odometry", options->odometry,
          "Poses of the sensor in a frame that may drift (TUM or KITTI), to send on /tf for scans in files")
      ->type_name("FILE");
  verb->add_option("--speed", options->speed, "How fast time passes")
      ->check(CLI::Range(0.01, 1000.0))
      ->type_name("FACTOR")
      ->capture_default_str();
  verb->add_option("--rate", options->scan_rate, "Scans per second, of scans without times")
      ->check(CLI::Range(0.1, 1000.0))
      ->type_name("HZ")
      ->capture_default_str();
  verb->add_option("--wait", options->wait, "How long to wait for someone who listens")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
  verb->callback([options] { play(*options); });
}

}  // namespace evermap
