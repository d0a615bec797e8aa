// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

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
  std::size_t repeat = 1;
  double wait = 10;  ///< [s] for a listener
};

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point time) {
  return std::chrono::duration<double>(Clock::now() - time).count();
}

/// Lets the recording's time pass as fast as was asked for, and listens meanwhile how soon each cloud is
/// answered by a transform of its time.
class Stage {
 public:
  Stage(ScanPublisher& publisher, double speed) : publisher_(publisher), speed_(speed) {}

  /// The recording is played once more: what it says from now on comes `period` [s] after what it said last.
  void repeat(double period) { shift_ = last_ - first_ + period; }

  /// Returns when `time` [s] of the recording is reached, and tells it to /clock.
  void reach(double time) {
    if (!std::exchange(has_begun_, true)) {
      first_ = time;
      begin_ = Clock::now();
    }
    time += shift_;
    last_ = std::max(last_, time);
    constexpr double kStep = 0.1;  // [s] to look for a signal
    for (double left = 1; left > 0 && stop_signal() == 0;) {
      left = (time - first_) / speed_ - seconds_since(begin_);
      listen(std::clamp(left, 0.0, kStep));
    }
    publisher_.send_clock(time);
  }

  void send_cloud(Scan scan, const std::string& frame) {
    *scan.time += shift_;
    sent_[nanoseconds(*scan.time)] = Clock::now();
    publisher_.send_cloud(scan, frame);
    ++clouds_;
  }
  void send_transforms(std::vector<StampedTransform> transforms, bool is_static) {
    for (StampedTransform& transform : transforms) transform.time += shift_;
    publisher_.send_transforms(transforms, is_static);
  }
  void send_turn_rate(TurnRate rate) {
    rate.time += shift_;
    publisher_.send_turn_rate(rate);
  }
  void send_odometry(StampedTransform pose) {
    pose.time += shift_;
    publisher_.send_odometry(pose);
  }

  /// Waits for the last answers.
  void end() {
    constexpr double kPatience = 0.5;  // [s]
    for (const Clock::time_point begin = Clock::now(); !sent_.empty() && seconds_since(begin) < kPatience;)
      listen(kPatience - seconds_since(begin));
  }

  std::size_t clouds() const { return clouds_; }
  /// [ms] how long each answer took, ascending.
  std::vector<double> answers() const {
    std::vector<double> sorted = answers_;
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  }

 private:
  static std::int64_t nanoseconds(double time) { return std::llround(1e9 * time); }

  void listen(double seconds) {
    constexpr std::int64_t kRounding = 2000;  // [ns] of a time as a double and back
    for (const StampedTransform& heard : publisher_.listen(seconds)) {
      const auto sent = sent_.lower_bound(nanoseconds(heard.time) - kRounding);
      if (sent == sent_.end() || sent->first > nanoseconds(heard.time) + kRounding) continue;
      answers_.push_back(1e3 * seconds_since(sent->second));
      sent_.erase(sent_.begin(), std::next(sent));  // those before are not answered any more
    }
  }

  ScanPublisher& publisher_;
  double speed_;
  bool has_begun_ = false;
  double first_ = 0;  ///< [s]
  double last_ = 0;   ///< [s] as it is told
  double shift_ = 0;  ///< [s] from the recording's time to what is told
  Clock::time_point begin_;
  std::map<std::int64_t, Clock::time_point> sent_;  ///< clouds without an answer, by their times [ns]
  std::vector<double> answers_;                     ///< [ms]
  std::size_t clouds_ = 0;
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
void play_scans(const PlayOptions& options, Stage& stage) {
  const std::string frame = "lidar";
  ScanOptions reading = options.reading;
  ScanPoses odometry(options.odometry, options.recording, reading);
  const std::unique_ptr<ScanSource> scans = open_scans(options.recording, reading);
  const ProgressBar bar(scans->size() * options.repeat);
  bool is_matched = false;
  while (std::optional<Scan> scan = stop_signal() == 0 ? scans->next() : std::nullopt) {
    if (!std::exchange(is_matched, true)) odometry.match(*scans, options.recording, *scan);
    const double by_count = static_cast<double>(scans->index() + 1) / options.scan_rate;
    const double time = scan->time.value_or(odometry.time(*scans).value_or(by_count));
    scan->time = time;
    const std::optional<Pose> T_odom_sensor = odometry.end_of(*scan, *scans);
    stage.reach(time);
    stage.send_cloud(std::move(*scan), frame);
    if (T_odom_sensor) {
      constexpr double kAfter = 1e-3;  // [s] odometry is known beyond the scan's end
      stage.send_transforms(
          {{time, "odom", frame, *T_odom_sensor}, {time + kAfter, "odom", frame, *T_odom_sensor}}, false);
    }
    bar.show(stage.clouds());
  }
}

/// A bag's clouds, transforms and odometry.
void play_bag(const PlayOptions& options, Stage& stage) {
  const std::unique_ptr<BagReader> bag = open_bag(options.recording);
  const std::vector<BagTopic>& topics = bag->topics();
  const std::size_t clouds = find_cloud_topic(*bag, options.reading.topic);
  const ProgressBar bar(topics[clouds].messages * options.repeat);
  while (const std::optional<BagMessage> message = stop_signal() == 0 ? bag->next() : std::nullopt) {
    const BagTopic& topic = topics[message->topic];
    if (message->topic == clouds) {
      const CloudMessage cloud = read_cloud_message(topic, message->bytes, bag->path());
      stage.reach(message->time);
      stage.send_cloud(cloud.scan, cloud.frame);
      bar.show(stage.clouds());
    } else if (kind_of(topic.type) == MessageKind::kTransforms) {
      stage.reach(message->time);
      stage.send_transforms(read_transforms(topic, message->bytes), topic.name.ends_with("tf_static"));
    } else if (kind_of(topic.type) == MessageKind::kImu) {
      stage.reach(message->time);
      if (const std::optional<TurnRate> rate = read_turn_rate(topic, message->bytes))
        stage.send_turn_rate(*rate);
    } else if (topic.type == "nav_msgs/Odometry") {
      stage.reach(message->time);
      for (const StampedTransform& pose : read_transforms(topic, message->bytes)) stage.send_odometry(pose);
    }
  }
  if (!bag->damage().empty()) throw FileError(bag->path(), bag->damage());
}

void play(const PlayOptions& options) {
  ScanPublisher publisher(options.domain, options.is_local, options.points, options.odometry_topic);
  catch_stop_signals();
  wait_for_listener(publisher, options.wait);
  Stage stage(publisher, options.speed);
  for (std::size_t round = 0; round < options.repeat && stop_signal() == 0; ++round) {
    if (round > 0) stage.repeat(1 / options.scan_rate);
    if (is_bag(options.recording)) {
      play_bag(options, stage);
    } else {
      play_scans(options, stage);
    }
  }
  stage.end();
  fmt::print("played   {} clouds of {}\n", stage.clouds(), options.recording.string());
  const std::vector<double> answers = stage.answers();
  if (answers.empty()) {
    fmt::print("answers  none on /tf\n");
  } else {
    fmt::print("answers  {} on /tf, half of them within {:.1f} ms, 99 % within {:.1f} ms\n", answers.size(),
               answers[answers.size() / 2], answers[99 * answers.size() / 100]);
  }
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
  verb->add_option("--repeat", options->repeat, "Play it so many times, one after the other")
      ->check(CLI::PositiveNumber)
      ->type_name("N")
      ->capture_default_str();
  verb->add_option("--wait", options->wait, "How long to wait for someone who listens")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
  verb->callback([options] { play(*options); });
}

}  // namespace evermap
