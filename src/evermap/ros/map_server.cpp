// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <deque>
#include <future>
#include <ros_messages.h>
#include <sstream>
#include <utility>

#include <evermap/bags/detail/gyroscope.hpp>
#include <evermap/bags/detail/messages.hpp>
#include <evermap/bags/detail/transform_buffer.hpp>
#include <evermap/files/detail/background.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/history/background_store.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/ros/detail/dds.hpp>
#include <evermap/ros/detail/map_topics.hpp>
#include <evermap/ros/map_server.hpp>

namespace evermap {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point time) {
  return std::chrono::duration<double>(Clock::now() - time).count();
}

/// [s] since 1970
double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

constexpr double kGap = 2;            // [s] without clouds, after which nothing is predicted
constexpr double kOdometryGap = 0.5;  // [s] without odometry, after which it is done without
constexpr double kSetBack = 1;        // [s] by which a clock goes back when it is set, and no sooner
constexpr double kSilence = 1;        // [s] without clouds that the robot is told of

}  // namespace

class MapServer::Node {
 public:
  Node(MapStore& store, Octree map, const Parameters& parameters, const MapCause& cause,
       const ServerOptions& options)
      : options_(options),
        parameters_(parameters),
        map_path_(store.path()),
        map_(std::move(map)),
        map_frame_(map_->frame().name),
        T_map_base_(options.T_map_base_initial),
        mode_(options.mode),
        store_(store, *map_, cause, options.journal),
        dds_(options.domain, options.is_local),
        clouds_(dds_, options.points, sensor_msgs_msg_dds__PointCloud2__desc, Delivery::kSensorData, 4),
        transforms_(dds_, "/tf", tf2_msgs_msg_dds__TFMessage__desc, Delivery::kReliable, 100),
        static_transforms_(dds_, "/tf_static", tf2_msgs_msg_dds__TFMessage__desc, Delivery::kLatched, 100),
        odometry_(dds_, options.odometry, nav_msgs_msg_dds__Odometry__desc, Delivery::kSensorData, 100),
        imu_(dds_, options.imu, sensor_msgs_msg_dds__Imu__desc, Delivery::kSensorData, 400),
        initial_poses_(dds_, "/initialpose", geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
                       Delivery::kReliable, 1),
        commands_(dds_, "/" + options.name + "/command", std_msgs_msg_dds__String__desc, Delivery::kReliable,
                  10),
        topics_(dds_, options.name, map_frame_),
        saving_(options.save_period),
        published_(*map_),
        compared_(*map_) {}

  std::optional<ScanResult> step(double seconds) {
    dds_.wait(waiting_.empty() ? seconds : std::min(seconds, kPatience / 4));
    take_transforms();
    take_initial_poses();
    take_commands();
    take_clouds();
    std::optional<ScanResult> result;
    if (std::optional<CloudMessage> cloud = next_cloud()) result = process(std::move(*cloud));
    publish_map();
    publish_changes();
    if (diagnosing_.is_over()) topics_.send_diagnosis(now(), diagnosis());
    keep();
    return result;
  }

  void finish(bool is_left_to_journal) {
    store_.wait();
    if (counts_.believed > 0) write_tum_poses(options_.last_pose, {{last_time_, T_map_base_}});
    if (is_left_to_journal && store_.has_journal()) return store_.leave(map(), counts_.used);
    if (is_saved()) return;
    store_.commit(map(), words_of_run());
    store_.wait();
    if (!store_.failure().empty()) throw std::runtime_error(store_.failure());
  }

  Octree map() const { return maintainer_ ? maintainer_->map() : *map_; }

  const ServerCounts& counts() const { return counts_; }
  const Pose& base_pose() const { return T_map_base_; }
  const std::vector<Eigen::Vector3d>& p_sensor_of_last() const { return p_sensor_of_last_; }

  using Reply = std::function<void(const std::string& reply)>;

  void command(const std::string& text, Reply reply) {
    std::istringstream words(text);
    std::string verb;
    std::string version;
    words >> verb >> version;
    if (verb == "save") {
      answer_when_done(words_of_run(), text, std::move(reply));
    } else if (verb == "pause" || verb == "resume") {
      mode_ = verb == "pause" ? MapMode::kLocalization : MapMode::kMaintenance;
      if (maintainer_) maintainer_->set_mode(mode_);
      reply(text + ": done");
    } else if (verb == "relocalize") {
      restart_at(T_map_base_);
      reply(text + ": done");
    } else if (verb == "reset" && !version.empty()) {
      reset(version, text, std::move(reply));
    } else {
      reply(text + ": unknown; there are save, pause, resume, relocalize and reset VERSION");
    }
  }

  Diagnosis diagnosis() const {
    Diagnosis diagnosis;
    const double silence = seconds_since(last_cloud_);
    if (!store_.failure().empty()) {
      diagnosis = {Diagnosis::kError, "the map cannot be saved: " + store_.failure(), {}};
    } else if (!has_begun_ || silence > kSilence) {
      diagnosis = {Diagnosis::kWarning, "no cloud comes on " + options_.points, {}};
    } else if (state_ == TrackingState::kLost) {
      diagnosis = {Diagnosis::kError, "lost: the scan " + std::string(to_string(reason_)), {}};
    } else if (state_ != TrackingState::kTracking || reason_ != RejectReason::kNone) {
      diagnosis.level = Diagnosis::kWarning;
      diagnosis.message = std::string(to_string(state_));
      if (reason_ != RejectReason::kNone)
        diagnosis.message += ": the scan " + std::string(to_string(reason_));
    } else if (has_rival_) {
      diagnosis = {Diagnosis::kWarning, "another node tells where " + map_frame_ + " is, too, on /tf", {}};
    } else if (clouds_.writers() > 1) {
      diagnosis = {Diagnosis::kWarning,
                   std::to_string(clouds_.writers()) + " publish on " + options_.points + "; one is used",
                   {}};
    } else {
      diagnosis.message = std::string(to_string(state_));
    }
    const auto add = [&](const char* key, const auto& value) {
      std::ostringstream words;
      words << value;
      diagnosis.values.emplace_back(key, words.str());
    };
    add("state", to_string(state_));
    add("map is maintained", mode_ == MapMode::kMaintenance ? "yes" : "no");
    add("pose of", has_begun_ && base_ != options_.base_frame
                       ? base_ + ", for /tf does not connect it with " + options_.base_frame
                       : base_);
    add("odometry", uses_odometry_ ? "used" : "none");
    add("gyroscope", gyroscope_.empty()               ? "none"
                     : gyroscope_.reaches(last_time_) ? "used"
                                                      : "tells no turn at the clouds' times");
    add("clouds used", counts_.used);
    add("clouds believed", counts_.believed);
    add("clouds too old when their turn came", counts_.stale);
    add("clouds not later than the one before", counts_.not_later);
    add("clouds damaged", counts_.damaged);
    add("clouds without odometry at their time", counts_.without_odometry);
    add("clouds of another publisher", counts_.foreign);
    add("last damage", fault_);
    add("milliseconds for the last cloud", milliseconds_);
    return diagnosis;
  }

 private:
  struct WaitingCloud {
    CloudMessage message;
    Clock::time_point arrival;
  };
  struct PendingCommand {
    std::string text;
    Reply reply;
  };

  /// Tells when something that is done again and again is to be done.
  class Period {
   public:
    explicit Period(double seconds) : seconds_(seconds) {}

    bool is_over() {
      if (seconds_since(last_) < seconds_) return false;
      last_ = Clock::now();
      return true;
    }

   private:
    double seconds_;
    Clock::time_point last_ = Clock::now();
  };

  static constexpr double kPatience = 0.2;  // [s] that odometry may come later than its cloud

  // ---- What comes in ----

  void take_transforms() {
    const auto add_all = [&](DdsReader& reader, bool is_static) {
      for (const DdsMessage& message : reader.take()) {
        for (const StampedTransform& transform : read_transforms(reader.topic(), message.bytes)) {
          const bool is_ours = transform.parent == map_frame_ && (transform.child == options_.odom_frame ||
                                                                  transform.child == options_.base_frame);
          has_rival_ = has_rival_ || is_ours;
          if (!is_ours) frames_.add(transform, is_static);
        }
      }
    };
    add_all(static_transforms_, true);
    add_all(transforms_, false);
    add_all(odometry_, false);
    for (const DdsMessage& message : imu_.take()) {
      if (const auto rate = read_turn_rate(imu_.topic(), message.bytes)) gyroscope_.add(*rate);
    }
  }

  void take_initial_poses() {
    for (const DdsMessage& message : initial_poses_.take()) {
      for (const StampedTransform& pose : read_transforms(initial_poses_.topic(), message.bytes)) {
        if (!pose.parent.empty() && pose.parent != map_frame_) {
          topics_.send_reply("initialpose: refused, it is in the frame " + pose.parent + ", the map in " +
                             map_frame_);
          continue;
        }
        restart_at(pose.T_parent_child);
      }
    }
  }

  void take_clouds() {
    std::vector<DdsMessage> messages = clouds_.take();
    std::erase_if(messages, [&](const DdsMessage& message) { return !is_of_our_sensor(message); });
    if (messages.empty()) return;
    counts_.stale += messages.size() - 1;
    last_cloud_ = Clock::now();
    try {
      waiting_.push_back(
          {read_cloud_message(clouds_.topic(), messages.back().bytes, clouds_.topic().name), Clock::now()});
    } catch (const FileError& error) {
      ++counts_.damaged;
      fault_ = error.what();
    }
  }

  /// Two sensors on one topic would tell of two places; the first is heard as long as it sends.
  bool is_of_our_sensor(const DdsMessage& message) {
    if (message.writer != sensor_ && (sensor_ == 0 || seconds_since(last_cloud_) > kSilence))
      sensor_ = message.writer;
    counts_.foreign += message.writer == sensor_ ? 0 : 1;
    return message.writer == sensor_;
  }

  std::optional<Pose> odometry_at(double time, const CloudMessage& cloud) const {
    return frames_.lookup(options_.odom_frame, cloud.frame, time);
  }

  /// The freshest cloud that can be used now; those before it are too old then.
  std::optional<CloudMessage> next_cloud() {
    for (std::size_t i = waiting_.size(); i-- > 0;) {
      WaitingCloud& cloud = waiting_[i];
      const double time = *cloud.message.scan.time;
      const bool is_fresh = seconds_since(cloud.arrival) <= kPatience;
      const bool is_odometry_coming =
          !odometry_at(time, cloud.message) && odometry_at(time - kPatience, cloud.message);
      const bool is_turn_coming = !gyroscope_.reaches(time) && gyroscope_.reaches(time - kPatience);
      if (is_fresh && (is_odometry_coming || is_turn_coming)) continue;
      counts_.stale += i;
      std::optional<CloudMessage> next = std::move(cloud.message);
      waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      return next;
    }
    return std::nullopt;
  }

  // ---- The scan ----

  /// The robot is searched around a place, without a guess of its speed.
  void restart_at(const Pose& T_map_base) {
    T_map_base_ = T_map_base;
    T_map_odom_.reset();
    begin_anew(map());
  }
  void begin_anew(Octree map) {
    map_ = std::move(map);
    maintainer_.reset();
  }

  std::optional<ScanResult> process(CloudMessage cloud) {
    const double time = *cloud.scan.time;
    if (time <= last_time_ && time > last_time_ - kSetBack) {
      ++counts_.not_later;
      return std::nullopt;
    }
    if (time <= last_time_) {
      frames_.forget_motion();
      gyroscope_.forget();
      waiting_.clear();
      T_map_odom_.reset();
    }
    const std::optional<Pose> T_odom_sensor = odometry_at(time, cloud);
    if (T_odom_sensor) last_odometry_ = time;
    if (uses_odometry_ && !T_odom_sensor && std::abs(time - last_odometry_) <= kOdometryGap) {
      ++counts_.without_odometry;
      return std::nullopt;
    }
    const bool is_gap = has_begun_ && (time <= last_time_ || time > last_time_ + kGap);
    const std::optional<Pose> T_sensor_base = frames_.lookup(cloud.frame, options_.base_frame, time);
    base_ = T_sensor_base ? options_.base_frame : cloud.frame;
    const Pose T_base_sensor = T_sensor_base.value_or(Pose{}).inverse();
    if (is_gap && T_map_odom_ && T_odom_sensor)
      T_map_base_ = *T_map_odom_ * *T_odom_sensor * T_base_sensor.inverse();
    if (!maintainer_ || is_gap || uses_odometry_ != T_odom_sensor.has_value())
      maintainer_ = std::make_unique<MapMaintainer>(map(), parameters_, mode_, T_map_base_ * T_base_sensor);
    map_.reset();
    has_begun_ = true;
    uses_odometry_ = T_odom_sensor.has_value();
    last_time_ = time;

    const Clock::time_point begin = Clock::now();
    const ScanResult result = maintainer_->process(cloud.scan, time, T_odom_sensor,
                                                   gyroscope_.rotation_of(cloud.frame, frames_, time));
    milliseconds_ = 1e3 * seconds_since(begin);
    last_cloud_ = Clock::now();  // nobody was listened to meanwhile
    ++counts_.used;
    counts_.written += result.is_written ? 1 : 0;
    state_ = result.state;
    reason_ = result.reject_reason;
    if (result.is_believed()) tell(result, cloud.frame, T_base_sensor, T_odom_sensor);
    p_sensor_of_last_ = std::move(cloud.scan.p_sensor);
    return result;
  }

  void tell(const ScanResult& result, const std::string& frame, const Pose& T_base_sensor,
            const std::optional<Pose>& T_odom_sensor) {
    ++counts_.believed;
    T_map_base_ = result.T_map_sensor * T_base_sensor.inverse();
    if (T_odom_sensor) T_map_odom_ = result.T_map_sensor * T_odom_sensor->inverse();
    if (T_odom_sensor) {
      topics_.send_transform(result.time, options_.odom_frame, *T_map_odom_);
    } else {
      topics_.send_transform(result.time, base_, T_map_base_);
    }
    topics_.send_pose(result, base_, base_ == frame ? Pose{} : T_base_sensor.inverse());
  }

  // ---- What goes out ----

  void publish_map() {
    if (!publishing_.is_over()) return;
    const std::size_t readers = topics_.map_readers();
    const bool is_new_reader = readers > map_readers_;
    map_readers_ = readers;
    if (!is_new_reader && !topics_.has_update_readers()) return;
    const Octree reached = map();
    if (is_new_reader) topics_.send_map(now(), reached);
    topics_.send_updates(now(), published_, reached);
    published_ = reached;
  }

  void publish_changes() {
    if (changes_.valid()) {
      if (changes_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
      topics_.send_changes(now(), changes_.get());
    }
    if (!comparing_.is_over()) return;
    const Octree before = std::exchange(compared_, map());
    changes_ = in_background([before, after = compared_] { return surface_changes(before, after); });
  }

  // ---- The map file ----

  bool is_saved() const { return counts_.written == saved_; }
  std::string words_of_run() const { return "serve, " + std::to_string(counts_.used) + " scans"; }

  void keep() {
    if (!store_.is_idle()) return;
    for (const PendingCommand& done : std::exchange(under_way_, {}))
      done.reply(done.text + (store_.failure().empty() ? ": done" : ": failed, " + store_.failure()));
    if (!pending_commit_.empty() || (saving_.is_over() && !is_saved())) {
      store_.commit(map(), pending_commit_.empty() ? words_of_run() : pending_commit_);
      under_way_ = std::exchange(pending_commands_, {});
      pending_commit_.clear();
      saved_ = counts_.written;
    } else if (noting_.is_over() && counts_.believed > noted_) {
      noted_ = counts_.believed;
      store_.start([path = options_.last_pose, time = last_time_, pose = T_map_base_] {
        write_tum_poses(path, {{time, pose}});
      });
    } else if (!is_saved()) {
      store_.acknowledge([&] { return map(); }, counts_.used);
    }
  }

  void take_commands() {
    for (const DdsMessage& message : commands_.take()) {
      WireReader reader(message.bytes, Wire::kCdr);
      command(std::string(reader.text()), [this](const std::string& reply) { topics_.send_reply(reply); });
    }
  }

  /// Has a version made; whoever asked for it is told when it is.
  void answer_when_done(std::string words, const std::string& command, Reply reply) {
    pending_commit_ = std::move(words);
    pending_commands_.push_back({command, std::move(reply)});
  }

  void reset(const std::string& version, const std::string& command, Reply reply) {
    try {
      Octree earlier = load_map_version(map_path_.string() + "@" + version);
      if (earlier.grid() != compared_.grid() || earlier.frame() != compared_.frame())
        throw FileError(map_path_, "that version has another leaf edge or frame; start again with it");
      begin_anew(std::move(earlier));
    } catch (const FileError& error) {
      return reply(command + ": failed, " + error.what());
    }
    answer_when_done("reset to version " + version, command, std::move(reply));
  }

  ServerOptions options_;
  Parameters parameters_;
  std::filesystem::path map_path_;
  std::optional<Octree> map_;  ///< that the next maintainer begins with; none while there is one
  std::string map_frame_;
  Pose T_map_base_;                 ///< where the base was last believed to be
  std::optional<Pose> T_map_odom_;  ///< at that time
  MapMode mode_;
  BackgroundStore store_;

  DdsNode dds_;
  DdsReader clouds_;
  DdsReader transforms_;
  DdsReader static_transforms_;
  DdsReader odometry_;
  DdsReader imu_;
  DdsReader initial_poses_;
  DdsReader commands_;
  MapTopics topics_;

  TransformBuffer frames_;
  Gyroscope gyroscope_;
  std::deque<WaitingCloud> waiting_;  ///< for odometry at their time
  std::uint64_t sensor_ = 0;          ///< who sends the clouds
  Clock::time_point last_cloud_ = Clock::now();
  std::string base_;                           ///< frame whose pose is told
  std::unique_ptr<MapMaintainer> maintainer_;  ///< none until a cloud comes to begin with
  bool has_begun_ = false;
  bool uses_odometry_ = false;
  bool has_rival_ = false;
  double last_time_ = 0;      ///< [s] of the clouds
  double last_odometry_ = 0;  ///< [s] when it was last known
  TrackingState state_ = TrackingState::kStarting;
  RejectReason reason_ = RejectReason::kNone;
  double milliseconds_ = 0;
  std::string fault_;
  ServerCounts counts_;
  std::vector<Eigen::Vector3d> p_sensor_of_last_;  ///< [m]

  Period publishing_{1};
  Period diagnosing_{1};
  Period comparing_{10};
  Period noting_{5};
  Period saving_;
  Octree published_;  ///< the map as listeners know it
  Octree compared_;   ///< as it was when changes were last told
  std::size_t map_readers_ = 0;
  std::future<std::vector<SurfaceChange>> changes_;
  std::string pending_commit_;                    ///< words of a version that is to be made
  std::vector<PendingCommand> pending_commands_;  ///< that asked for it
  std::vector<PendingCommand> under_way_;         ///< whose version is being made
  std::size_t saved_ = 0;                         ///< scans in the map when the last version was made
  std::size_t noted_ = 0;                         ///< believed scans when the pose was last kept
};

MapServer::MapServer(MapStore& store, Octree map, const Parameters& parameters, const MapCause& cause,
                     const ServerOptions& options)
    : node_(std::make_unique<Node>(store, std::move(map), parameters, cause, options)) {}
MapServer::~MapServer() = default;
std::optional<ScanResult> MapServer::step(double seconds) { return node_->step(seconds); }
void MapServer::finish(bool is_left_to_journal) { node_->finish(is_left_to_journal); }
Octree MapServer::map() const { return node_->map(); }
void MapServer::command(const std::string& text, std::function<void(const std::string&)> reply) {
  node_->command(text, std::move(reply));
}
const ServerCounts& MapServer::counts() const { return node_->counts(); }
Diagnosis MapServer::diagnosis() const { return node_->diagnosis(); }
const Pose& MapServer::base_pose() const { return node_->base_pose(); }
const std::vector<Eigen::Vector3d>& MapServer::p_sensor_of_last() const { return node_->p_sensor_of_last(); }

}  // namespace evermap
