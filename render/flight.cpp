#include "render/flight.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

namespace tintree::render {
namespace {

using nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLeastFov = 1 * kDegree;
constexpr double kMostFov = 170 * kDegree;
constexpr double kFarthest_m = 1e12;  ///< Beyond it a double has no millimetres left.
constexpr double kLatest_s = 1e10;    ///< Beyond it a double has no microseconds left.

bool sane(const glm::dvec3& p) {
  const auto near = [](double v) { return std::abs(v) <= kFarthest_m; };
  return near(p.x) && near(p.y) && near(p.z);
}

std::string keyframe_name(std::size_t i) { return fmt::format("keyframe {}", i + 1); }

/// Derivative at keyframe i of the parabola through it and its neighbours, of the chord at the ends.
glm::dvec3 velocity(const std::vector<Keyframe>& keys, std::size_t i, glm::dvec3 Keyframe::*point) {
  const auto slope = [&](std::size_t a) {
    return (keys[a + 1].*point - keys[a].*point) / (keys[a + 1].seconds - keys[a].seconds);
  };
  if (i == 0) return slope(0);
  if (i + 1 == keys.size()) return slope(i - 1);
  const double before = keys[i].seconds - keys[i - 1].seconds;
  const double after = keys[i + 1].seconds - keys[i].seconds;
  return (after * slope(i - 1) + before * slope(i)) / (before + after);
}

glm::dvec3 hermite(const std::vector<Keyframe>& keys, std::size_t i, double seconds, glm::dvec3 Keyframe::*point) {
  const double span = keys[i + 1].seconds - keys[i].seconds;
  const double t = (seconds - keys[i].seconds) / span;
  const double s = 1 - t;
  return (1 + 2 * t) * s * s * (keys[i].*point) + t * s * s * span * velocity(keys, i, point) +
         t * t * (1 + 2 * s) * (keys[i + 1].*point) - t * t * s * span * velocity(keys, i + 1, point);
}

/// Reads members of one object and remembers the first thing that is wrong.
class Members {
 public:
  Members(const ordered_json& object, std::string name) : object_(object), name_(std::move(name)) {
    if (!object.is_object()) blame("is not an object in braces");
  }

  const std::string& fault() const { return fault_; }
  bool has(const char* key) const { return fault_.empty() && object_.contains(key); }
  void blame(const std::string& what) {
    if (fault_.empty()) fault_ = name_.empty() ? what : name_ + ": " + what;
  }

  double number(const char* key) {
    if (!has(key) || !object_[key].is_number()) {
      blame(fmt::format("\"{}\" wants a number", key));
      return 0;
    }
    return object_[key].get<double>();
  }

  glm::dvec3 point(const char* key) {
    const bool is_point = has(key) && object_[key].is_array() && object_[key].size() == 3 &&
                          std::ranges::all_of(object_[key], [](const auto& v) { return v.is_number(); });
    if (!is_point) {
      blame(fmt::format("\"{}\" wants three numbers in metres, [x, y, z]", key));
      return glm::dvec3(0);
    }
    const ordered_json& p = object_[key];
    return {p[0].get<double>(), p[1].get<double>(), p[2].get<double>()};
  }

  /// A misspelt member would otherwise be passed over in silence.
  void allow(std::initializer_list<const char*> known) {
    if (!fault_.empty()) return;
    for (const auto& [key, value] : object_.items()) {
      if (std::ranges::find(known, key) == known.end()) blame(fmt::format("\"{}\" is unknown", key));
    }
  }

 private:
  const ordered_json& object_;
  std::string name_;
  std::string fault_;
};

Keyframe read_keyframe(Members& m) {
  m.allow({"seconds", "eye_m", "target_m", "azimuth_deg", "elevation_deg"});
  Keyframe key;
  key.seconds = m.number("seconds");
  key.eye = m.point("eye_m");
  if (m.has("target_m")) {
    key.target = m.point("target_m");
    if (m.has("azimuth_deg") || m.has("elevation_deg")) m.blame("has a target and angles; leave one of them out");
    return key;
  }
  if (!m.has("azimuth_deg")) m.blame("wants \"target_m\", or \"azimuth_deg\" and \"elevation_deg\"");
  const double azimuth = m.number("azimuth_deg") * kDegree;
  const double elevation = m.number("elevation_deg") * kDegree;
  const double level = std::cos(elevation);
  key.target = key.eye + glm::dvec3(std::sin(azimuth) * level, std::cos(azimuth) * level, std::sin(elevation));
  return key;
}

}  // namespace

Expected<Flight> Flight::create(std::vector<Keyframe> keyframes, double fov_y_rad) {
  const auto bad = [](const std::string& what) { return fail(ErrorCode::kBadData, what); };
  if (keyframes.size() < 2) return bad("a flight wants two keyframes or more");
  if (!(fov_y_rad >= kLeastFov && fov_y_rad <= kMostFov)) return bad("\"fov_y_deg\" wants 1 to 170 degrees");
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const Keyframe& k = keyframes[i];
    if (!std::isfinite(k.seconds) || !sane(k.eye) || !sane(k.target))
      return bad(keyframe_name(i) + ": a number is infinite, or a place farther than 1e12 m");
    if (glm::distance(k.eye, k.target) < 1e-6) return bad(keyframe_name(i) + ": the eye is its target; move one");
    if (std::abs(k.seconds) > kLatest_s || k.seconds - keyframes[0].seconds > kLongest_s)
      return bad(keyframe_name(i) +
                 ": \"seconds\" wants at most 1e6 more than the first keyframe has, and 1e10 in all");
    constexpr double kRounded = 0.99;
    if (i > 0 && !(k.seconds - keyframes[i - 1].seconds >= kRounded * kLeastApart_s))
      return bad(keyframe_name(i) + ": \"seconds\" wants more than the keyframe before has, by a millisecond or more");
  }
  Flight out;
  out.keyframes_ = std::move(keyframes);
  out.fov_y_rad_ = fov_y_rad;
  return out;
}

Expected<Flight> Flight::from_json(const std::string& text, const std::string& where) {
  const auto json = ordered_json::parse(text, nullptr, false);
  if (json.is_discarded()) {
    return fail(ErrorCode::kBadData,
                "is no JSON, or has a number beyond all bounds; a flight looks as in docs/guide.md, Flights", where);
  }
  Members top(json, "");
  top.allow({"fov_y_deg", "keyframes"});
  const double fov = top.has("fov_y_deg") ? top.number("fov_y_deg") * kDegree : kDefaultFovRad;
  if (!top.has("keyframes") || !json["keyframes"].is_array()) top.blame("\"keyframes\" wants a list of keyframes");
  if (!top.fault().empty()) return fail(ErrorCode::kBadData, top.fault(), where);
  std::vector<Keyframe> keyframes;
  for (const ordered_json& key : json["keyframes"]) {
    Members members(key, keyframe_name(keyframes.size()));
    keyframes.push_back(read_keyframe(members));
    if (!members.fault().empty()) return fail(ErrorCode::kBadData, members.fault(), where);
  }
  auto flight = create(std::move(keyframes), fov);
  if (!flight) flight.error().where = where;
  return flight;
}

Expected<Flight> Flight::load(const std::string& path) {
  const std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file.is_open() || text.bad() || std::filesystem::is_directory(path))
    return fail(ErrorCode::kIo, "cannot be read; name a flight's JSON file", path);
  return from_json(text.str(), path);
}

std::string Flight::to_json() const {
  ordered_json keys = ordered_json::array();
  for (const Keyframe& k : keyframes_) {
    keys.push_back({{"seconds", k.seconds},
                    {"eye_m", {k.eye.x, k.eye.y, k.eye.z}},
                    {"target_m", {k.target.x, k.target.y, k.target.z}}});
  }
  return ordered_json{{"fov_y_deg", fov_y_rad_ / kDegree}, {"keyframes", std::move(keys)}}.dump(2) + '\n';
}

Camera Flight::at(double seconds, int width_px, int height_px) const {
  const double time = std::clamp(seconds, begin_s(), end_s());
  const auto after = std::ranges::upper_bound(keyframes_, time, {}, &Keyframe::seconds);
  const auto last = static_cast<std::ptrdiff_t>(keyframes_.size()) - 2;
  const auto i = static_cast<std::size_t>(std::clamp(after - keyframes_.begin() - 1, std::ptrdiff_t{0}, last));
  Camera camera;
  camera.eye = hermite(keyframes_, i, time, &Keyframe::eye);
  camera.target = hermite(keyframes_, i, time, &Keyframe::target);
  // Where the curves meet, between views to opposite sides, it goes on looking as before.
  if (glm::distance(camera.eye, camera.target) < 1e-6) {
    camera.target = camera.eye + glm::normalize(keyframes_[i].target - keyframes_[i].eye);
  }
  camera.fov_y_rad = fov_y_rad_;
  camera.width_px = width_px;
  camera.height_px = height_px;
  return camera;
}

}  // namespace tintree::render
