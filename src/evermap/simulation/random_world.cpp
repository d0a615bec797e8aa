// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <random>
#include <sstream>
#include <utility>
#include <vector>

#include <evermap/simulation/draw.hpp>
#include <evermap/simulation/random_world.hpp>

namespace evermap {
namespace {

/// A scenario that is drawn, object by object.
class World : public ScenarioText {
 public:
  World(std::uint64_t seed, const RandomDrive& drive) : random_(seed), drive_(drive) {}

  double uniform(double from, double to) { return evermap::uniform(random_, from, to); }
  bool chance(double probability) { return uniform(0, 1) < probability; }

  /// Places from `begin` to before `end`, `least` to `most` apart.
  std::vector<double> places(double begin, double end, double least, double most) {
    std::vector<double> places;
    double at = begin;
    while (at < end) {
      places.push_back(at);
      at += uniform(least, most);
    }
    return places;
  }

  /// As box, but it may have come, gone or moved since the survey.
  void furniture(const Box& box) {
    std::string text = text_of(box);
    if (chance(drive_.changed)) {
      const double what = uniform(0, 3);
      if (what < 1) text += ", survey: only";
      if (what >= 1 && what < 2) text += ", survey: absent";
      if (what >= 2) {
        std::ostringstream moved;
        moved << ", survey: {at: [" << box.x + uniform(-0.5, 0.5) << ", " << box.y + uniform(-0.5, 0.5)
              << "]}";
        text += moved.str();
      }
    }
    object(text);
  }
  /// Gravel that was more or less when it was surveyed.
  void pile(double x, double y) {
    const double height = uniform(1.2, 3.5);
    std::ostringstream text;
    text << "pile: {height: " << height << "}, at: [" << x << ", " << y << "]";
    if (chance(2 * drive_.changed))
      text << ", survey: {pile: {height: " << height * uniform(0.5, 1.5) << "}}";
    object(text.str());
  }
  void body(const char* name, double x, double y, double yaw) {
    std::ostringstream text;
    text << "body: " << name << ", at: [" << x << ", " << y << ", " << yaw << "]";
    if (chance(drive_.changed)) text << (chance(0.5) ? ", survey: only" : ", survey: absent");
    object(text.str());
  }
  void ceiling(double x, double y, double height) { box({0, 0, 0, 2 * x + 0.9, 2 * y + 0.9, 0.2, height}); }

  /// A straight drive with one bend, at up to `speed` [m/s].
  void route(double x0, double y0, double x1, double y1, double x2, double y2, double speed, double radius) {
    std::ostringstream text;
    const double first = drive_.starts_at_speed ? speed : 0.1 * speed;
    constexpr double kAcceleration = 3;  // [m/s^2]
    const double ahead = std::min(0.9, speed * speed / (2 * kAcceleration) / std::hypot(x1 - x0, y1 - y0));
    text << "route: {speed: " << speed << ", turn_radius: " << radius
         << ", start: " << (drive_.starts_at_speed ? 0.0 : 0.5) << ", end: stay, waypoints: [{at: [" << x0
         << ", " << y0 << "], speed: " << first << "}, {at: [" << x0 + ahead * (x1 - x0) << ", "
         << y0 + ahead * (y1 - y0) << "], speed: " << speed << "}, [" << x1 << ", " << y1 << "], [" << x2
         << ", " << y2 << "]]}";
    ScenarioText::route(text.str());
  }

  std::string text(std::uint64_t seed) const { return ScenarioText::text(seed, drive_); }

 private:
  std::mt19937_64 random_;
  RandomDrive drive_;
};

const char* const kLevel = "{slope: [0, 0]}";
const char* const kWavy = "{waves: {amplitude: 0.12, length: [35, 28], phase: 0.7}}";

void room(World& w) {
  const double x = w.uniform(3.5, 12), y = w.uniform(2.5, 7), height = w.uniform(2.4, 3.5);
  w.walls(x, y, height, w.uniform(0.1, 0.3));
  w.ceiling(x, y, height);
  for (int i = 0; i < 8; ++i) {  // along the walls
    const double side = i % 2 == 0 ? 1 : -1;
    w.furniture({w.uniform(-x + 1, x - 1), side * (y - 0.4), 0, w.uniform(0.5, 1.5), 0.6, w.uniform(0.5, 2)});
  }
  w.ground(x + 0.6, y + 0.6, kLevel);
  w.route(-0.6 * x, -0.3 * y, 0, -0.3 * y, 0, 0.6 * y, w.uniform(0.4, 1.2), 0.5);
}

void corridor(World& w) {
  const double x = w.uniform(12, 30), y = w.uniform(0.8, 2), height = w.uniform(2.4, 3);
  w.walls(x, y, height, w.uniform(0.1, 0.3));
  w.ceiling(x, y, height);
  for (const double at : w.places(-x + 1, x - 1, 2, 6))
    w.furniture({at, w.chance(0.5) ? y - 0.15 : -y + 0.15, 0, w.uniform(0.4, 1), 0.3, w.uniform(0.8, 2)});
  w.ground(x + 0.6, y + 0.6, kLevel);
  w.route(-0.6 * x, 0, 0, 0, 0.6 * x, 0.1, w.uniform(0.8, 1.8), 0.5);
}

void tunnel(World& w) {
  const double x = 40, y = w.uniform(2, 4), height = w.uniform(3, 5);
  w.walls(x, y, height, 0.4);
  w.ceiling(x, y, height);
  for (const double at : w.places(-x + 3, x - 3, 4, 10))  // what stands out makes niches between
    w.box({at, w.chance(0.5) ? y - 0.3 : -y + 0.3, 0, w.uniform(1, 3), 0.6, height - 0.2});
  w.ground(x + 0.8, y + 0.8, kLevel);
  w.sensor_height(1.6);
  w.route(-20, 0, 0, 0, 20, 0.3, w.uniform(2, 6), 2);
}

void hall(World& w) {
  const double x = w.uniform(15, 30), y = w.uniform(10, 20);
  w.walls(x, y, w.uniform(4, 8), 0.3);
  for (int i = 0; i < 10; ++i) {
    const double side = i % 2 == 0 ? 1 : -1;
    w.furniture({w.uniform(-x + 3, x - 3), side * w.uniform(0.5 * y, 0.85 * y), w.uniform(0, 90),
                 w.uniform(1, 4), w.uniform(0.8, 2), w.uniform(1, 3)});
  }
  w.ground(x + 0.6, y + 0.6, kLevel);
  const double speed = w.uniform(0.8, 2), radius = w.uniform(0.6, 2);
  w.route(-6, -3, 0, -3, 0, 2.5, speed, radius);
}

void warehouse(World& w) {
  const double x = 20, y = 12;
  w.walls(x, y, 6, 0.3);
  const double pitch = w.uniform(2.6, 3.4);
  for (const double row : w.places(-9, 9, pitch, pitch)) {
    if (std::abs(row) < 1.2) continue;
    for (const double at : w.places(-14, 14, 2.8, 2.8)) {
      w.box({at, row, 0, 2.7, 0.9, w.uniform(2, 4)});
      if (w.chance(0.4)) w.furniture({at, row, 0, 1.2, 1.1, w.uniform(0.8, 1.6)});
    }
  }
  w.ground(x + 0.6, y + 0.6, kLevel);
  w.route(-12, 0, 0, 0, 12, 0.2, w.uniform(1, 2.5), 0.8);
}

void containers(World& w) {
  const double reach = 35;
  w.walls(reach, reach, 3, 0.3);
  for (int i = 0; i < 24; ++i) {
    const double x = w.uniform(-30, 30), y = w.uniform(-30, 30);
    const double yaw = w.chance(0.5) ? w.uniform(-5, 5) : 90, length = w.chance(0.5) ? 12 : 6;
    const double along = length / 2 + 1.5, across = 3;  // from its middle, with room to pass
    if (std::abs(x) < 9 + (yaw == 90 ? across : along) && std::abs(y) < 8 + (yaw == 90 ? along : across))
      continue;
    w.furniture({x, y, yaw, length, 2.4, 2.6});
  }
  w.pile(-15, w.uniform(-6, 6));
  w.pile(15, w.uniform(-6, 6));
  w.ground(reach + 2, reach + 2, kWavy);
  w.sensor_height(1.8);
  w.route(-9, -4, 0, -4, 0, 8, w.uniform(3, 5), 4);
}

void street(World& w) {
  for (const double side : {-1.0, 1.0}) {
    for (const double at : w.places(-55, 55, 13, 20))
      w.box({at, side * w.uniform(10, 13), w.uniform(-2, 2), w.uniform(8, 13), 7, w.uniform(5, 12)});
    for (const double at : w.places(-50, 50, 6, 10)) w.body("car", at, side * 5, side > 0 ? 180 : 0);
    for (const double at : w.places(-50, 50, 12, 25)) w.post(at, side * 6.5, 6, 0.2);
  }
  w.ground(60, 20, "{slope: [0.02, 0]}");
  w.sensor_height(1.8);
  w.route(-25, -1.5, 0, -1.5, 25, -1, w.uniform(4, 12), 10);
}

void forest(World& w) {
  for (int i = 0; i < 90; ++i) {
    const double x = w.uniform(-40, 40), y = w.uniform(-40, 40);
    if (std::abs(y) < 3) continue;
    if (w.chance(0.5)) {
      w.body("tree", x, y, w.uniform(0, 360));
    } else {
      const double height = w.uniform(5, 12), width = w.uniform(0.2, 0.6);
      w.post(x, y, height, width);
    }
  }
  w.ground(45, 45,
           "{waves: {amplitude: 0.5, length: [25, 18], phase: 0.7}}, {roughness: {amplitude: 0.05, size: "
           "1.5, seed: 2}}");
  w.route(-10, 0, 0, 0, 10, 0.8, w.uniform(1, 3), 3);
}

void quarry(World& w) {
  for (int i = 0; i < 10; ++i) {
    const double side = w.chance(0.5) ? 1 : -1;
    w.furniture({w.uniform(-25, 25), side * w.uniform(7, 15), w.uniform(0, 180), 5, 2.5, 2.5});
  }
  for (const double middle : {-16.0, 2.0, 19.0}) {
    const double x = middle + w.uniform(-3, 3), y = w.uniform(10, 14);
    w.pile(x, y);
  }
  w.ground(45, 35,
           "{terraces: {center: [0, 0], size: [64, 44], corner: 10, count: 2, height: 4, face: 2, width: 3, "
           "wobble: 1}}, {roughness: {amplitude: 0.04, size: 1.5, seed: 2}}");
  w.sensor_height(2);
  w.route(-12, -3, 0, -3, 8, 4, w.uniform(2, 5), 4);
}

void parking(World& w) {
  const double x = w.uniform(18, 28), y = w.uniform(9, 15), height = w.uniform(2.2, 2.6);
  w.walls(x, y, height, 0.25);
  w.ceiling(x, y, height);
  for (const double at : w.places(-x + 3, x - 2, 5, 5)) {
    for (const double row : {-4.5, 4.5}) w.box({at, row, 0, 0.4, 0.4, height - 0.05});
    if (w.chance(0.6)) w.body("car", at + 2.5, 7, 90);
    if (w.chance(0.6)) w.body("car", at + 2.5, -7, 90);
  }
  w.ground(x + 0.6, y + 0.6, kLevel);
  w.sensor_height(1.5);
  w.route(-10, 0, 0, 0, 10, 1, w.uniform(1.5, 4), 3);
}

/// A storey above a part of the ground, which the robot drives under.
void floors(World& w) {
  const double x = w.uniform(10, 16), y = w.uniform(7, 11), height = w.uniform(2.6, 3.2);
  w.walls(x, y, 2 * height, 0.3);
  w.box({-x / 2, 0, 0, x, 2 * y + 0.5, 0.3, height});
  for (int i = 0; i < 8; ++i) {
    w.furniture({w.uniform(-x + 1, x - 1), (i % 2 == 0 ? 1 : -1) * (y - 0.8), 0, w.uniform(0.8, 2), 0.9,
                 w.uniform(0.6, 2)});
  }
  for (const double row : {-3.0, 3.0}) w.box({-0.3, row, 0, 0.4, 0.4, height - 0.05});
  w.ground(x + 0.6, y + 0.6, kLevel);
  w.route(-0.5 * x, 0, 0, 0, 0.5 * x, 0.5, w.uniform(0.8, 2), 1);
}

}  // namespace

std::string random_world(std::string_view kind, std::uint64_t seed, const RandomDrive& drive) {
  using Fill = void (*)(World&);
  constexpr std::array<Fill, kWorldKinds.size()> kFill = {
      room, corridor, tunnel, hall, warehouse, containers, street, forest, quarry, parking, floors};
  World world(seed, drive);
  for (std::size_t i = 0; i < kWorldKinds.size(); ++i) {
    if (kWorldKinds[i] == kind) kFill[i](world);
  }
  return world.text(seed);
}

}  // namespace evermap
