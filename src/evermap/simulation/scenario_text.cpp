// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/simulation/scenario_text.hpp>

namespace evermap {

std::string text_of(const Box& box) {
  std::ostringstream text;
  text << "box: [" << box.length << ", " << box.width << ", " << box.height << "], at: [" << box.x << ", "
       << box.y << ", " << box.yaw << "]";
  if (box.lift > 0) text << ", lift: " << box.lift;
  return text.str();
}

void ScenarioText::box(const Box& box) { object(text_of(box)); }

void ScenarioText::wall(double x0, double y0, double x1, double y1, double height, double thickness) {
  std::ostringstream text;
  text << "wall: {from: [" << x0 << ", " << y0 << "], to: [" << x1 << ", " << y1 << "], height: " << height
       << ", thickness: " << thickness << "}";
  object(text.str());
}

void ScenarioText::walls(double x, double y, double height, double thickness) {
  const double t = thickness / 2;
  wall(-x - t, y + t, x + t, y + t, height, thickness);
  wall(-x - t, -y - t, x + t, -y - t, height, thickness);
  wall(-x - t, -y - t, -x - t, y + t, height, thickness);
  wall(x + t, -y - t, x + t, y + t, height, thickness);
}

void ScenarioText::post(double x, double y, double height, double width) {
  std::ostringstream text;
  text << "post: {height: " << height << ", width: " << width << "}, at: [" << x << ", " << y << "]";
  object(text.str());
}

void ScenarioText::object(const std::string& keys) {
  objects_ << "  - {name: o" << ++count_ << ", " << keys << "}\n";
}

void ScenarioText::ground(double x, double y, const std::string& features) {
  std::ostringstream text;
  text << "ground: {area: [" << -x << ", " << -y << ", " << x << ", " << y
       << "], spacing: 0.5, reflectivity: 0.4, features: [" << features << "]}\n";
  ground_ = text.str();
}

std::string ScenarioText::text(std::uint64_t seed, const RandomDrive& drive) const {
  std::ostringstream text;
  text << "seed: " << seed << "\nscans: " << drive.scans << "\nlidar: {channels: " << drive.channels
       << ", columns: " << drive.columns
       << ", elevation: [-22, 18], rate: 10, min_range: 0.3, max_range: 80, range_sigma: 0.02, "
          "motion_distortion: true}\n"
       << ground_ << "robot: {sensor_height: " << sensor_height_ << ", " << route_ << "}\nobjects:\n"
       << objects_.str();
  return text.str();
}

}  // namespace evermap
