// SPDX-License-Identifier: Apache-2.0
#include "tool/view/camera_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "tool/json.h"

namespace bcc4 {
namespace {

void read_vector(const Json& json, const std::string& key, double (&out)[3], const std::string& path) {
  const Json& list = json[key];
  bool good = list.is_array() && list.size() == 3;
  for (size_t i = 0; good && i < 3; ++i) {
    good = list[i].is_number();
    if (good) out[i] = list[i].get<double>();
  }
  if (!good) fail_input(path, ": ", key, " must be a list of three numbers");
}

double read_positive(const Json& json, const std::string& key, const std::string& path) {
  if (!json[key].is_number() || !(json[key].get<double>() > 0))
    fail_input(path, ": ", key, " must be a positive number");
  return json[key].get<double>();
}

bccsplat_camera read_camera(const Json& json, const std::string& path) {
  for (const char* key : {"position", "target"})
    if (!json.contains(key)) fail_input(path, ": \"", key, "\" is missing");
  auto c = bccsplat_camera{};
  c.struct_size = sizeof c;
  read_vector(json, "position", c.position, path);
  read_vector(json, "target", c.target, path);
  c.up[1] = 1;
  if (json.contains("up")) read_vector(json, "up", c.up, path);
  const bool perspective = json.contains("fovy_deg"), orthographic = json.contains("ortho_height");
  if (perspective == orthographic)
    fail_input(path, ": give either fovy_deg (perspective) or ortho_height (orthographic)");
  c.projection = perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  if (perspective)
    c.fovy_degrees = read_positive(json, "fovy_deg", path);
  else
    c.ortho_height = read_positive(json, "ortho_height", path);
  return c;
}

void check_keys(const Json& json, const std::vector<std::string>& keys, const std::string& path) {
  if (!json.is_object()) fail_input(path, ": a camera is a JSON object");
  for (const auto& [key, value] : json.items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      fail_input(path, ": unknown key \"", key, "\"", did_you_mean(key, keys), "; a camera has ", join(keys));
}

} // namespace

CameraFile read_camera_file(const std::string& path) {
  const Json json = Json::parse(read_text_file(path, 64 << 20), nullptr, false);
  const std::vector<std::string> own{"position", "target", "up", "fovy_deg", "ortho_height"};
  std::vector<std::string> all = own;
  all.insert(all.end(), {"resolution", "frames"});
  check_keys(json, all, path);
  CameraFile out;
  if (json.contains("frames")) {
    const Json& frames = json["frames"];
    if (!frames.is_array() || frames.empty()) fail_input(path, ": frames must be a list of cameras");
    for (const Json& frame : frames) {
      check_keys(frame, own, path);
      Json whole = json;
      // Either way of seeing replaces the other.
      if (frame.contains("fovy_deg")) whole.erase("ortho_height");
      if (frame.contains("ortho_height")) whole.erase("fovy_deg");
      whole.update(frame);
      out.cameras.push_back(read_camera(whole, path));
    }
  } else {
    out.cameras.push_back(read_camera(json, path));
  }
  if (json.contains("resolution")) {
    const Json& r = json["resolution"];
    if (!r.is_array() || r.size() != 2 || !r[0].is_number_unsigned() || !r[1].is_number_unsigned())
      fail_input(path, ": resolution must be two whole numbers");
    out.resolution = {r[0].get<uint32_t>(), r[1].get<uint32_t>()};
  }
  return out;
}

bccsplat_camera turned(const bccsplat_camera& camera, double degrees) {
  bccsplat_camera c = camera;
  const double length = std::hypot(c.up[0], c.up[1], c.up[2]);
  const double angle = degrees * std::numbers::pi / 180, cosine = std::cos(angle), sine = std::sin(angle);
  double up[3], v[3];
  for (int i = 0; i < 3; ++i) up[i] = c.up[i] / length, v[i] = c.position[i] - c.target[i];
  const double along = up[0] * v[0] + up[1] * v[1] + up[2] * v[2];
  for (int i = 0; i < 3; ++i) { // Rodrigues' formula
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    c.position[i] =
        c.target[i] + cosine * v[i] + sine * (up[j] * v[k] - up[k] * v[j]) + (1 - cosine) * along * up[i];
  }
  return c;
}

bccsplat_camera zoomed(const bccsplat_camera& camera, double factor) {
  bccsplat_camera c = camera;
  constexpr double degree = std::numbers::pi / 180;
  c.ortho_height /= factor;
  c.fovy_degrees = 2 * std::atan(std::tan(c.fovy_degrees * degree / 2) / factor) / degree;
  return c;
}

} // namespace bcc4
