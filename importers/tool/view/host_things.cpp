// SPDX-License-Identifier: Apache-2.0
#include "tool/view/host_things.h"

#include <algorithm>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "tool/handles.h"
#include "tool/json.h"
#include "tool/options.h"

namespace bcc4 {
namespace {

void read_matrix(const Json& json, const std::string& key, double (&out)[16], const std::string& path) {
  const bool there = json.contains(key) && json[key].is_array() && json[key].size() == 16;
  for (size_t i = 0; i < 16; ++i) {
    if (!there || !json[key][i].is_number())
      fail_input(path, ": \"", key, "\" must be a list of 16 numbers, row by row");
    out[i] = json[key][i].get<double>();
  }
}

} // namespace

bccsplat_view HostThings::view(const bccsplat_camera& camera) const {
  auto v = matrices ? *matrices : sized<bccsplat_view>();
  if (!matrices) v.camera = &camera;
  if (over) {
    v.background = over->rgba.data();
    if (!over->depth.empty()) v.depth = over->depth.data(), v.depth_kind = BCCSPLAT_DEPTH_PLANAR;
  }
  return v;
}

bccsplat_clip parse_clip(const std::string& text) {
  const std::vector<double> numbers = option_numbers("--clip", text, 4);
  bccsplat_clip clip{};
  for (size_t a = 0; a < 3; ++a) clip.normal[a] = numbers[a];
  clip.offset = numbers[3];
  if (numbers[0] == 0 && numbers[1] == 0 && numbers[2] == 0)
    fail_usage("--clip ", text, ": a, b and c are the plane's normal and must not all be 0");
  return clip;
}

std::vector<bccsplat_clip> parse_box(const std::string& text) {
  const std::vector<double> n = option_numbers("--box", text, 6);
  double box[16] = {};
  for (size_t a = 0; a < 3; ++a) {
    if (!(n[a] < n[a + 3])) fail_usage("--box ", text, ": x0 < x1, y0 < y1 and z0 < z1 are expected");
    box[5 * a] = n[a + 3] - n[a], box[4 * a + 3] = n[a];
  }
  box[15] = 1;
  std::vector<bccsplat_clip> faces(6);
  check(bccsplat_make_box_clips(box, faces.data()), "--box");
  return faces;
}

void read_view_matrices(const std::string& path, HostThings& out) {
  const Json json = Json::parse(read_text_file(path, 1 << 20), nullptr, false);
  if (!json.is_object()) fail_input(path, ": a view is a JSON object with world_to_view and projection");
  const std::vector<std::string> keys{"world_to_view", "projection", "depth", "y_down", "resolution"};
  for (const auto& [key, value] : json.items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      fail_input(path, ": unknown key \"", key, "\"", did_you_mean(key, keys), "; a view has ", join(keys));
  auto v = sized<bccsplat_view>();
  v.use_matrices = 1;
  read_matrix(json, "world_to_view", v.world_to_view, path);
  read_matrix(json, "projection", v.projection, path);
  if (json.contains("depth")) {
    if (!json["depth"].is_string()) fail_input(path, ": depth is \"0..1\", \"-1..1\" or \"reversed\"");
    v.depth_range = option_choice<int32_t>(path + ": depth", json["depth"].get<std::string>(),
                                           {{"0..1", BCCSPLAT_DEPTH_RANGE_ZERO_ONE},
                                            {"-1..1", BCCSPLAT_DEPTH_RANGE_MINUS_ONE_ONE},
                                            {"reversed", BCCSPLAT_DEPTH_RANGE_REVERSED}});
  }
  if (json.contains("y_down")) {
    if (!json["y_down"].is_boolean()) fail_input(path, ": y_down is true or false");
    v.y_down = json["y_down"].get<bool>() ? 1 : 0;
  }
  if (json.contains("resolution")) {
    const Json& r = json["resolution"];
    if (!r.is_array() || r.size() != 2 || !r[0].is_number_unsigned() || !r[1].is_number_unsigned())
      fail_input(path, ": resolution must be two whole numbers");
    out.resolution = {r[0].get<uint32_t>(), r[1].get<uint32_t>()};
  }
  out.matrices = v;
}

} // namespace bcc4
