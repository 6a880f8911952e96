// SPDX-License-Identifier: Apache-2.0
// Bakes maps into stops of linear light, which the library blends in: 256 steps where a map is blended in
// another space. Reads and writes ParaView's JSON and warns of what has no counterpart, such as midpoints.
#include "tool/view/transfer_function.h"

#include <algorithm>
#include <cmath>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "tool/json.h"

namespace bcc4 {
namespace {

constexpr int kBaked = 256; // colours between the ends of a map that is not blended in linear light

struct BuiltIn {
  const char* name;
  std::vector<std::array<double, 3>> stops; // display colours at equal distances
};

const std::vector<BuiltIn>& built_ins() {
  static const std::vector<BuiltIn> maps{
      {"viridis",
       {{.267, .005, .329},
        {.283, .141, .458},
        {.254, .265, .530},
        {.207, .372, .553},
        {.164, .471, .558},
        {.128, .567, .551},
        {.135, .659, .518},
        {.267, .749, .441},
        {.478, .821, .318},
        {.741, .873, .150},
        {.993, .906, .144}}},
      {"magma",
       {{.001, .000, .014},
        {.114, .065, .277},
        {.316, .072, .485},
        {.513, .148, .508},
        {.716, .215, .475},
        {.904, .319, .388},
        {.986, .535, .382},
        {.996, .762, .529},
        {.987, .991, .750}}},
      {"inferno",
       {{.001, .000, .014},
        {.120, .047, .284},
        {.342, .062, .429},
        {.550, .134, .415},
        {.736, .216, .330},
        {.888, .333, .213},
        {.978, .557, .035},
        {.977, .780, .170},
        {.988, .998, .645}}},
      {"turbo",
       {{.136, .091, .107},
        {.288, .244, .686},
        {.269, .415, .935},
        {.197, .586, .970},
        {.148, .740, .881},
        {.162, .866, .733},
        {.250, .953, .573},
        {.401, .993, .428},
        {.589, .982, .313},
        {.777, .921, .231},
        {.932, .814, .177},
        {1, .670, .142},
        {1, .502, .114},
        {.935, .329, .084},
        {.786, .175, .047},
        {.632, .070, .006},
        {.566, .050, .000}}},
      {"jet",
       {{0, 0, .5},
        {0, 0, 1},
        {0, .5, 1},
        {0, 1, 1},
        {.5, 1, .5},
        {1, 1, 0},
        {1, .5, 0},
        {1, 0, 0},
        {.5, 0, 0}}},
      {"gray", {{0, 0, 0}, {1, 1, 1}}},
      {"fire", {{0, 0, 0}, {.45, .02, 0}, {.85, .15, 0}, {1, .50, .03}, {1, .85, .25}, {1, 1, .85}}}};
  return maps;
}

std::array<double, 4> point(double value, const Color& display) {
  return {value, srgb_to_linear(display[0]), srgb_to_linear(display[1]), srgb_to_linear(display[2])};
}

std::vector<double> json_numbers(const Json& map, const char* key, size_t group, const std::string& path) {
  if (!map.contains(key)) return {};
  const Json& list = map[key];
  std::vector<double> numbers;
  if (list.is_array())
    for (const Json& n : list)
      if (n.is_number()) numbers.push_back(n.get<double>());
  if (!list.is_array() || numbers.size() != list.size() || numbers.size() % group != 0 || numbers.empty())
    fail_input(path, ": ", key, " must be a list of numbers in groups of ", group);
  for (const double n : numbers)
    if (!std::isfinite(n)) fail_input(path, ": ", key, " holds a number that is not finite");
  for (size_t i = group; i < numbers.size(); i += group)
    if (numbers[i] < numbers[i - group])
      fail_input(path, ": the values of ", key, " must rise, but ", numbers[i], " follows ",
                 numbers[i - group]);
  return numbers;
}

void bake(TransferFunction& f, const std::vector<double>& rgb, BlendSpace space, bool steps) {
  const auto display = [&](size_t i) {
    return Color{std::clamp(rgb[4 * i + 1], 0.0, 1.0), std::clamp(rgb[4 * i + 2], 0.0, 1.0),
                 std::clamp(rgb[4 * i + 3], 0.0, 1.0)};
  };
  const size_t points = rgb.size() / 4;
  const double span = rgb[rgb.size() - 4] - rgb[0];
  for (size_t i = 0; i + 1 < points; ++i) {
    const double low = rgb[4 * i], high = rgb[4 * i + 4];
    f.colors.push_back(point(low, display(i)));
    if (steps) {
      f.colors.push_back(point(high, display(i)));
      continue;
    }
    const int between = span > 0 ? static_cast<int>(std::ceil(kBaked * (high - low) / span)) : 1;
    for (int k = 1; k < between; ++k) {
      const double t = static_cast<double>(k) / between;
      f.colors.push_back(point(low + t * (high - low), blend(display(i), display(i + 1), t, space)));
    }
  }
  f.colors.push_back(point(rgb[rgb.size() - 4], display(points - 1)));
}

} // namespace

std::vector<std::string> colormap_names() {
  std::vector<std::string> names;
  for (const BuiltIn& map : built_ins()) names.emplace_back(map.name);
  return names;
}

TransferFunction colormap(const std::string& name, double low, double high) {
  for (const BuiltIn& map : built_ins()) {
    if (name != map.name) continue;
    std::vector<double> rgb;
    for (size_t i = 0; i < map.stops.size(); ++i) {
      rgb.push_back(low + (high - low) * static_cast<double>(i) / static_cast<double>(map.stops.size() - 1));
      rgb.insert(rgb.end(), map.stops[i].begin(), map.stops[i].end());
    }
    TransferFunction f;
    bake(f, rgb, BlendSpace::rgb, false);
    return f;
  }
  const auto names = colormap_names();
  fail_usage("--colormap ", name, ": must be ", join(names, " or "), did_you_mean(name, names));
}

TransferFunction read_paraview_json(const std::string& path, std::string& warning) {
  const Json document = Json::parse(read_text_file(path, 64 << 20), nullptr, false);
  if (document.is_discarded()) fail_input(path, ": is no JSON");
  const Json& map = document.is_array() && !document.empty() ? document[0] : document;
  if (!map.is_object() || (!map.contains("RGBPoints") && !map.contains("Points")))
    fail_input(path, ": no ParaView colour map: it has no RGBPoints",
               map.is_object() && map.contains("IndexedColors")
                   ? "; categories (IndexedColors) cannot be drawn"
                   : "");
  static constexpr std::pair<const char*, BlendSpace> spaces[] = {
      {"RGB", BlendSpace::rgb}, {"Step", BlendSpace::rgb},   {"HSV", BlendSpace::hsv},
      {"Lab", BlendSpace::lab}, {"CIELAB", BlendSpace::lab}, {"Diverging", BlendSpace::diverging}};
  const std::string space = map.contains("ColorSpace") && map["ColorSpace"].is_string()
                                ? map["ColorSpace"].get<std::string>()
                                : "RGB";
  const auto known =
      std::find_if(std::begin(spaces), std::end(spaces), [&](const auto& s) { return space == s.first; });
  if (known == std::end(spaces)) warning += concat("colour space ", space, " is unknown, RGB was used; ");
  TransferFunction f;
  const std::vector<double> rgb = json_numbers(map, "RGBPoints", 4, path);
  if (!rgb.empty())
    bake(f, rgb, known == std::end(spaces) ? BlendSpace::rgb : known->second, space == "Step");
  const std::vector<double> points = json_numbers(map, "Points", 4, path);
  for (size_t i = 0; i < points.size(); i += 4) {
    f.opacities.push_back({points[i], std::clamp(points[i + 1], 0.0, 1.0)});
    if (i + 4 < points.size() && (points[i + 2] != 0.5 || points[i + 3] != 0))
      warning += concat("midpoint and sharpness of the opacity at ", points[i], " are not honoured; ");
  }
  if (map.contains("ScalarOpacityUnitDistance") && map["ScalarOpacityUnitDistance"].is_number())
    f.unit_distance = map["ScalarOpacityUnitDistance"].get<double>();
  return f;
}

std::string paraview_json(const TransferFunction& f, const std::string& name) {
  Json map;
  map["ColorSpace"] = "RGB";
  map["Name"] = name;
  map["NanColor"] = {0, 0, 0};
  map["Points"] = Json::array();
  for (const auto& [value, opacity] : f.opacities)
    for (const double n : {value, opacity, 0.5, 0.0}) map["Points"].push_back(n);
  map["RGBPoints"] = Json::array();
  for (const auto& c : f.colors)
    for (const double n : {c[0], linear_to_srgb(c[1]), linear_to_srgb(c[2]), linear_to_srgb(c[3])})
      map["RGBPoints"].push_back(n);
  if (f.unit_distance > 0) map["ScalarOpacityUnitDistance"] = f.unit_distance;
  return Json::array({map}).dump(2) + "\n";
}

void rescale(TransferFunction& f, double low, double high) {
  double from = f.colors.empty() ? f.opacities.front()[0] : f.colors.front()[0];
  double to = f.colors.empty() ? f.opacities.back()[0] : f.colors.back()[0];
  if (!(to > from)) to = from + 1;
  const auto moved = [&](double v) { return low + (v - from) / (to - from) * (high - low); };
  for (auto& c : f.colors) c[0] = moved(c[0]);
  for (auto& o : f.opacities) o[0] = moved(o[0]);
}

void add_default_opacity(TransferFunction& f, double low, double high, const Emptiness& empty) {
  constexpr double most = 0.25, ringing = 0.02; // what a field rings three voxels from a sharp edge
  double air = empty.air;
  const auto [first, last] = empty.between;
  // The air of a file may be a value like others: where the data are nowhere empty, or empty of all up to
  // some value, or from one on. Then they have one side.
  const bool anywhere = first <= last, upwards = anywhere && std::isinf(first) && std::isfinite(last),
             downwards = anywhere && std::isinf(last) && std::isfinite(first);
  if (!anywhere) air = low;
  if (upwards && air > last) air = std::clamp(last, low, high);
  if (downwards && air < first) air = std::clamp(first, low, high);
  const double reach = std::max(std::abs(high - air), std::abs(low - air)), none = ringing * reach;
  const auto opacity = [&](double value) { return empty.opaque ? 1 : most * std::abs(value - air) / reach; };
  if (!upwards && low < air - none) f.opacities.push_back({low, opacity(low)});
  if (!upwards && empty.opaque && low < air - 2 * none) f.opacities.push_back({air - 2 * none, 1});
  if (low < air) f.opacities.push_back({air - none, 0});
  if (high > air) f.opacities.push_back({air + none, 0});
  if (!downwards && empty.opaque && high > air + 2 * none) f.opacities.push_back({air + 2 * none, 1});
  if (!downwards && high > air + none) f.opacities.push_back({high, opacity(high)});
}

void scale_opacity(TransferFunction& f, double factor) {
  for (auto& o : f.opacities) o[1] = std::clamp(o[1] * factor, 0.0, 1.0);
}

} // namespace bcc4
