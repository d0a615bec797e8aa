// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <sstream>
#include <vector>

#include <evermap/geometry/detail/degree.hpp>
#include <evermap/simulation/changing_place.hpp>
#include <evermap/simulation/draw.hpp>

namespace evermap {
namespace {

/// A place in which things of one kind stand, one at a time.
struct Bay {
  double x, y, yaw;    ///< [m], [m] and [degrees]
  std::string keys{};  ///< of the object that stands there; empty: none does
};

/// Draws what stands in a bay tonight.
using Draw = std::string (*)(std::mt19937_64& random, const Bay& bay);

/// What stands in the bays after so many nights, each of which redraws a fraction of them.
void fill(std::vector<Bay>& bays, Draw draw, std::uint64_t seed, int nights, double changed) {
  std::mt19937_64 random(seed);
  for (Bay& bay : bays) bay.keys = draw(random, bay);
  for (int night = 0; night < nights; ++night) {
    for (Bay& bay : bays) {
      if (uniform(random, 0, 1) < changed) bay.keys = draw(random, bay);
    }
  }
}

void stand(ScenarioText& text, const std::vector<Bay>& bays) {
  for (const Bay& bay : bays) {
    if (!bay.keys.empty()) text.object(bay.keys);
  }
}

/// A round along the rectangle [-x, x] x [-y, y].
std::string round_of(double x, double y, double speed, double radius) {
  std::ostringstream text;
  text << "route: {speed: " << speed << ", turn_radius: " << radius
       << ", start: 0.5, end: stay, waypoints: [{at: [" << -x << ", " << -y << "], speed: 0.5}, {at: ["
       << -x + 4 << ", " << -y << "], speed: " << speed << "}, [" << x << ", " << -y << "], [" << x << ", "
       << y << "], [" << -x << ", " << y << "], [" << -x << ", " << 4 - y << "]]}";
  return text.str();
}

std::string container(std::mt19937_64& random, const Bay& bay) {
  constexpr double kFilled = 0.7;   // of the bays
  constexpr double kStacked = 0.3;  // of the containers
  const double is_filled = uniform(random, 0, 1), is_stacked = uniform(random, 0, 1);
  const double x = bay.x + uniform(random, -0.4, 0.4), y = bay.y + uniform(random, -0.4, 0.4);
  const double yaw = bay.yaw + uniform(random, -2, 2);
  if (is_filled > kFilled) return {};
  return text_of({x, y, yaw, 6.06, 2.44, is_stacked < kStacked ? 5.18 : 2.59});
}

std::string machine(std::mt19937_64& random, const Bay& bay) {
  const auto body = one_of(random, {"", "", "truck", "loader", "excavator", "car"});
  const double x = bay.x + uniform(random, -1, 1), y = bay.y + uniform(random, -1, 1);
  std::ostringstream text;
  text << "body: " << body << ", at: [" << x << ", " << y << ", " << bay.yaw + uniform(random, -30, 30)
       << "]";
  return *body == '\0' ? std::string() : text.str();
}

std::string pile(std::mt19937_64& random, const Bay& bay) {
  const double height = uniform(random, -1, 4);
  std::ostringstream text;
  text << "pile: {height: " << height << "}, at: [" << bay.x << ", " << bay.y << "]";
  return height < 0.5 ? std::string() : text.str();
}

void container_terminal(ScenarioText& text, std::uint64_t seed, int nights, double changed) {
  std::vector<Bay> bays;
  for (const double x : {-7.2, 0.0, 7.2}) {
    for (const double y : {-3.4, 0.0, 3.4}) bays.push_back({x, y, 0});
  }
  for (const double y : {-18.5, -15.0, 15.0, 18.5}) {
    for (const double x : {-21.6, -14.4, -7.2, 0.0, 7.2, 14.4, 21.6}) bays.push_back({x, y, 0});
  }
  for (const double x : {-27.0, -23.0, 23.0, 27.0}) {
    for (const double y : {-7.2, 0.0, 7.2}) bays.push_back({x, y, 90});
  }
  fill(bays, container, seed, nights, changed);
  stand(text, bays);
  for (const double x : {-31.0, 31.0}) {
    for (const double y : {-23.0, 23.0}) text.post(x, y, 9, 0.3);
  }
  text.ground(45, 35, "{waves: {amplitude: 0.1, length: [45, 38], phase: 0.7}}");
  text.sensor_height(1.8);
  text.route(round_of(16, 9.5, 6, 4));
}

/// The blocks of rock around the pit's floor after so many nights, of which each blasts the next two back.
void rock(ScenarioText& text, std::mt19937_64& random, int nights) {
  constexpr double kBlock = 12;     // [m]
  constexpr double kBlasted = 2.5;  // [m]
  constexpr int kEachNight = 2;
  std::vector<Bay> faces;  // middles, looking at the floor along x
  for (const double along : {-24.0, -12.0, 0.0, 12.0, 24.0}) {
    faces.push_back({along, -24, 90});
    faces.push_back({-along, 24, -90});
  }
  for (const double along : {-18.0, -6.0, 6.0, 18.0}) {
    faces.push_back({-30, -along, 0});
    faces.push_back({30, along, 180});
  }
  const auto count = static_cast<int>(faces.size());
  for (int i = 0; i < count; ++i) {
    const Bay& face = faces[static_cast<std::size_t>(i)];
    const double height = uniform(random, 5, 9), set_back = uniform(random, 0, 1.5);
    const double turn = uniform(random, -5, 5);
    const int times = (kEachNight * nights + count - 1 - i) / count;
    const double depth = set_back + kBlasted * times + kBlock / 2;
    const double yaw = face.yaw * kDegree;
    text.box({face.x - depth * std::cos(yaw), face.y - depth * std::sin(yaw), face.yaw + turn, kBlock,
              kBlock + 1, height});
  }
}

/// The pit's floor after so many nights, of which each digs the next of its strips deeper.
std::string floor_of_pit(int nights) {
  constexpr int kStrips = 7;
  constexpr int kMiddle = 3;
  constexpr double kApart = 8;  // [m] the sides of neighbours add up to a level floor
  constexpr double kDug = 0.4;  // [m]
  std::ostringstream text;
  text << "{roughness: {amplitude: 0.3, size: 9, seed: 2}}, {roughness: {amplitude: 0.05, size: 1.5, seed: "
          "3}}";
  for (int strip = 0; strip < kStrips; ++strip) {
    const int times = (nights + kStrips - 1 - strip) / kStrips;
    const double x = (strip - kMiddle) * kApart;
    text << ", {embankment: {line: [[" << x << ", -14], [" << x << ", 14]], height: " << -kDug * times
         << ", width: 5, side: 3}}";
  }
  return text.str();
}

void pit(ScenarioText& text, std::uint64_t seed, int nights, double changed) {
  std::vector<Bay> piles, machines;
  for (const double x : {-9.0, 0.0, 9.0}) {
    for (const double y : {-17.0, 0.0, 17.0}) piles.push_back({x, y, 0});
  }
  for (const double x : {-23.0, 23.0}) {
    for (const double y : {-8.0, 0.0, 8.0}) machines.push_back({x, y, 90});
  }
  fill(piles, pile, seed, nights, changed);
  fill(machines, machine, seed + 1, nights, 2 * changed);
  stand(text, piles);
  stand(text, machines);
  std::mt19937_64 random(seed + 2);
  rock(text, random, nights);
  text.ground(75, 70, floor_of_pit(nights));
  text.sensor_height(2);
  text.route(round_of(16, 10, 6, 4));
}

}  // namespace

std::string changing_place(std::string_view place, std::uint64_t seed, int nights, const RandomDrive& drive) {
  ScenarioText text;
  (place == kChangingPlaces[0] ? container_terminal : pit)(text, seed, nights, drive.changed);
  return text.text(seed + static_cast<std::uint64_t>(nights), drive);
}

}  // namespace evermap
