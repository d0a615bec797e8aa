// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <charconv>
#include <openssl/evp.h>
#include <set>
#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

#include <evermap/files/file_error.hpp>
#include <evermap/history/detail/file_stamp.hpp>
#include <evermap/history/map_history.hpp>
#include <evermap/map/detail/leaf_changes.hpp>
#include <evermap/web/detail/map_tiles.hpp>
#include <evermap/web/detail/page.hpp>
#include <evermap/web/map_page.hpp>

namespace evermap {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNow = "now";
constexpr std::size_t kMostViews = 3;
constexpr std::uint16_t kThisRun = 0xFFFF;  ///< the version that is not made yet

/// A request asks for what is not there.
class NotFound : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }
WebReply json_reply(const Json& json) { return {200, "application/json", dump(json)}; }
WebReply text_reply(unsigned status, const std::string& words) {
  return {status, "text/plain; charset=utf-8", words + "\n"};
}

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
WebReply binary_reply(const std::vector<T>& values) {
  return {200, "application/octet-stream", bytes_of(values)};
}

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin < path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    if (end > begin) words.push_back(path.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

int number_of(const std::string& word) {
  int number = 0;
  const char* end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data(), end, number);
  if (parsed.ec != std::errc() || parsed.ptr != end)
    throw NotFound("\"" + word.substr(0, 80) + "\" is no number");
  return number;
}

/// A version, or two, by number where they were named by tag.
std::string with_numbers(const std::filesystem::path& map, const std::string& shown) {
  if (!MapHistory::exists_for(map)) return shown;
  const MapHistory history(map);
  const auto numbered = [&](const std::string& version) {
    return version == kNow ? version : std::to_string(history.number_of(version));
  };
  const std::size_t dots = shown.find("..");
  if (dots == std::string::npos) return numbered(shown);
  return numbered(shown.substr(0, dots)) + ".." + numbered(shown.substr(dots + 2));
}

std::uint16_t saturated(int version) {
  return static_cast<std::uint16_t>(std::clamp(version, 0, kThisRun - 1));
}

/// Adds what a version changed to the ages of leaves.
void add_ages(const MapVersion& version, const Octree& before, std::span<const LeafChange> changes,
              LeafAges& ages) {
  if (version.is_whole) return;  // as old as the history
  for (const LeafChange& change : changes)
    note_version(change, before.is_occupied(change.key), saturated(version.number), ages);
}

Json to_json(const TileBlock& block) {
  return {block.at[0], block.at[1], block.at[2], block.leaves, block.revision};
}

Json to_json(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

Json grid_json(const Octree& map) {
  return {{"frame", map.frame().name}, {"origin", to_json(map.grid().origin)}, {"edge", map.grid().edge}};
}

Json changes_json(const Octree& before, const Octree& after) {
  Json pieces = Json::array();
  for (const SurfaceChange& change : surface_changes(before, after)) {
    pieces.push_back({{"has_come", change.has_come},
                      {"min", to_json(change.box.min())},
                      {"max", to_json(change.box.max())},
                      {"leaves", change.leaves}});
  }
  return pieces;
}

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int size =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(size));
  return text;
}

}  // namespace

struct MapPage::View {
  FileStamp stamp;  ///< of the map file, when it was read
  std::mutex mutex;
  MapTiles tiles;
};

MapPage::MapPage(std::filesystem::path map, const std::string& shown)
    : map_(std::move(map)), shown_(with_numbers(map_, shown)) {
  try {
    view(shown_);
  } catch (const NotFound& error) {
    throw FileError(map_, error.what());
  }
}

MapPage::MapPage(std::filesystem::path map, const Octree& begun)
    : map_(std::move(map)), shown_(kNow), live_(new View{{}, {}, MapTiles(begun, begun)}) {}

MapPage::~MapPage() = default;

std::string MapPage::show(Octree map) {
  Json blocks = Json::array();
  {
    const std::lock_guard<std::mutex> lock(live_->mutex);
    for (const TileBlock& block : live_->tiles.show(std::move(map), kThisRun))
      blocks.push_back(to_json(block));
  }
  return blocks.empty() ? "" : dump({{"blocks", blocks}});
}

void MapPage::set_status(std::string json) {
  const std::lock_guard<std::mutex> lock(robot_mutex_);
  status_ = std::move(json);
}

void MapPage::set_commands(TakeCommand take) {
  const std::lock_guard<std::mutex> lock(robot_mutex_);
  take_command_ = std::move(take);
}

std::string MapPage::describe() {
  const std::shared_ptr<View> shown = view(shown_);
  Json json = {{"name", map_.filename().string()},
               {"live", live_ != nullptr},
               {"shown", shown_},
               {"changed", stamp_of(map_).changed}};
  {
    const std::lock_guard<std::mutex> lock(shown->mutex);
    json.update(grid_json(shown->tiles.map()));
  }
  Json versions = Json::array();
  if (MapHistory::exists_for(map_)) {
    for (const MapVersion& version : MapHistory(map_).versions()) {
      versions.push_back({{"number", version.number},
                          {"time", version.time},
                          {"what", version.cause.what},
                          {"leaves", version.leaves},
                          {"tags", version.tags}});
    }
  }
  json["versions"] = versions;
  return dump(json);
}

std::shared_ptr<MapPage::View> MapPage::load(const std::string& name) const {
  const FileStamp stamp = stamp_of(map_);
  LeafAges ages;
  const auto read = [&](const std::string& version, LeafAges* to) {
    const VersionVisitor note = [to](const MapVersion& made, const Octree& before,
                                     std::span<const LeafChange> changes) {
      if (to != nullptr) add_ages(made, before, changes, *to);
    };
    if (version != kNow) return MapHistory(map_).checkout(number_of(version), note);
    if (live_) {
      const std::lock_guard<std::mutex> lock(live_->mutex);
      return live_->tiles.map();
    }
    if (to != nullptr && MapHistory::exists_for(map_)) {
      const MapHistory history(map_);
      const std::vector<MapVersion> versions = history.versions();
      if (!versions.empty()) history.checkout(versions.back().number, note);
    }
    return load_map_version(map_);
  };
  const std::size_t dots = name.find("..");
  if (dots == std::string::npos) {
    Octree map = read(name, &ages);
    return std::shared_ptr<View>(
        new View{stamp, {}, MapTiles(std::move(map), std::nullopt, std::move(ages))});
  }
  Octree before = read(name.substr(0, dots), nullptr);
  Octree after = read(name.substr(dots + 2), &ages);
  if (before.grid() != after.grid())
    throw NotFound("these versions have leaves of another size, or in other places");
  return std::shared_ptr<View>(
      new View{stamp, {}, MapTiles(std::move(after), std::move(before), std::move(ages))});
}

std::shared_ptr<MapPage::View> MapPage::view(const std::string& name) {
  if (live_ && name == kNow) return live_;
  const std::lock_guard<std::mutex> lock(views_mutex_);
  auto found =
      std::find_if(views_.begin(), views_.end(), [&](const auto& known) { return known.first == name; });
  // Another process may have put another map in place.
  if (found != views_.end() && name.ends_with(kNow) && !live_ && found->second->stamp != stamp_of(map_)) {
    views_.erase(found);
    found = views_.end();
  }
  if (found == views_.end()) {
    views_.emplace_front(name, load(name));
    if (views_.size() > kMostViews) views_.pop_back();
    found = views_.begin();
  }
  views_.splice(views_.begin(), views_, found);
  return views_.front().second;
}

WebReply MapPage::reply_of_map(const std::string& name, const std::vector<std::string>& words) {
  const std::shared_ptr<View> shown = view(name);
  if (words.size() == 1 && words[0] == "blocks") {
    const std::lock_guard<std::mutex> lock(shown->mutex);
    return binary_reply(shown->tiles.blocks());
  }
  if (words.size() == 5 && words[0] == "tiles") {
    const int level = number_of(words[1]);
    if (level < 0 || level > MapTiles::kTopLevel) throw NotFound("there are levels 0 to 15");
    const Eigen::Vector3i at(number_of(words[2]), number_of(words[3]), number_of(words[4]));
    const std::lock_guard<std::mutex> lock(shown->mutex);
    return binary_reply(shown->tiles.tile(level, at));
  }
  if (words.size() == 1 && words[0] == "changes") {
    std::unique_lock<std::mutex> lock(shown->mutex);
    if (!shown->tiles.before()) throw NotFound("one map alone changed nothing; ask for two, 3..now");
    const Octree before = *shown->tiles.before();
    const Octree after = shown->tiles.map();
    lock.unlock();
    return json_reply(changes_json(before, after));
  }
  throw NotFound("there are blocks, tiles/LEVEL/X/Y/Z and changes");
}

WebReply MapPage::reply_to(const std::string& path) {
  const std::vector<std::string> words = split(path);
  if (words.empty()) return {200, "text/html; charset=utf-8", std::string(page())};
  if (words.size() >= 3 && words[0] == "api" && words[1] == "maps")
    return reply_of_map(words[2], {words.begin() + 3, words.end()});
  if (words.size() == 2 && words[0] == "api" && words[1] == "page")
    return {200, "application/json", describe()};
  if (words.size() == 2 && words[0] == "api" && words[1] == "status") {
    if (!live_) return json_reply({{"changed", stamp_of(map_).changed}});
    const std::lock_guard<std::mutex> lock(robot_mutex_);
    return {200, "application/json", status_.empty() ? "{}" : status_};
  }
  throw NotFound("there is no such thing");
}

void MapPage::respond(const WebRequest& request, const WebRespond& respond) {
  try {
    if (request.method == "POST" && request.path == "/api/command") {
      const Json json = Json::parse(request.body, nullptr, false);
      if (!json.is_object() || !json.contains("command") || !json["command"].is_string())
        return respond(text_reply(400, "send {\"command\": \"save\"}"));
      TakeCommand take;
      {
        const std::lock_guard<std::mutex> lock(robot_mutex_);
        take = take_command_;
      }
      if (!take) return respond(text_reply(404, "no robot takes commands here"));
      return take(json["command"].get<std::string>(), [respond](const std::string& reply) {
        respond(json_reply({{"reply", reply}}));
      });
    }
    if (request.method != "GET" && request.method != "HEAD")
      return respond(text_reply(405, "there is GET, and POST /api/command"));
    respond(reply_to(request.path));
  } catch (const NotFound& error) {
    respond(text_reply(404, error.what()));
  } catch (const FileError& error) {
    respond(text_reply(404, error.what()));
  }
}

std::string page_with_map(const Octree& map, const std::optional<Octree>& before, const std::string& title) {
  constexpr std::size_t kMostPoints = 800'000;  // 17 MB
  MapTiles tiles(map, before);
  const std::vector<TileBlock> blocks = tiles.blocks();
  int level = 0;
  // A surface has a quarter of the cells at each level.
  for (std::size_t points = map.leaf_count(); points > kMostPoints && level < MapTiles::kTopLevel;
       points /= 4)
    ++level;
  std::set<std::array<std::int32_t, 3>> places;
  for (const TileBlock& block : blocks)
    places.insert({block.at[0] >> level, block.at[1] >> level, block.at[2] >> level});
  Json list = Json::array();
  for (const std::array<std::int32_t, 3>& at : places)
    list.push_back({{"at", at}, {"points", base64(bytes_of(tiles.tile(level, {at[0], at[1], at[2]})))}});
  Json data = {{"name", title}, {"live", false}, {"shown", kNow}, {"versions", Json::array()}};
  data.update(grid_json(map));
  data["level"] = level;
  data["blocks"] = base64(bytes_of(blocks));
  data["tiles"] = list;
  data["changes"] = before ? changes_json(*before, map) : Json(nullptr);
  std::string text = dump(data);
  // What a file is named must not end the script that it stands in.
  for (std::size_t at = text.find("</"); at != std::string::npos; at = text.find("</", at))
    text.replace(at, 2, "<\\/");
  std::string whole(page());
  constexpr std::string_view kPlace = "<!--map-->";
  const std::size_t place = whole.find(kPlace);
  return whole.replace(place, kPlace.size(),
                       "<script type=\"application/json\" id=\"map-data\">" + text + "</script>");
}

}  // namespace evermap
