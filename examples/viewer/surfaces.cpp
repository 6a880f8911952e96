// SPDX-License-Identifier: Apache-2.0
#include "viewer/surfaces.h"

#include <bccsplat.h>

#include <charconv>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace viewer {
namespace {

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  if (text.empty() || text.back() == at) parts.emplace_back(); // which getline leaves out
  return parts;
}

template<class T, class... Base> bool read(const std::string& text, T& value, Base... base) {
  const char* const end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value, base...);
  return error == std::errc() && last == end;
}

double linear(unsigned byte) {
  const double v = byte / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

bool read_color(const std::string& text, std::array<double, 3>& color) {
  unsigned rgb = 0;
  if (text.size() != 7 || text[0] != '#' || !read(text.substr(1), rgb, 16)) return false;
  color = {linear(rgb >> 16), linear(rgb >> 8 & 255), linear(rgb & 255)};
  return true;
}

} // namespace

std::vector<Surface> parse_surfaces(const std::string& text) {
  std::vector<Surface> surfaces;
  for (const std::string& one : split(text, ',')) {
    const std::vector<std::string> parts = split(one, ':');
    Surface s;
    s.colored = parts.size() == 3;
    const bool good = !parts.empty() && parts.size() <= 3 && read(parts[0], s.value) &&
                      std::isfinite(s.value) && (parts.size() < 2 || read(parts[1], s.opacity)) &&
                      s.opacity >= 0 && s.opacity <= 1 && (!s.colored || read_color(parts[2], s.color));
    if (!good)
      throw std::runtime_error("--iso " + text +
                               ": V[:OPACITY[:#RRGGBB]] is expected, several with commas, opacities 0 to 1");
    surfaces.push_back(s);
  }
  if (surfaces.size() > BCCSPLAT_MAX_ISO_SURFACES)
    throw std::runtime_error("--iso " + text + ": at most " + std::to_string(BCCSPLAT_MAX_ISO_SURFACES) +
                             " values");
  return surfaces;
}

void move_surfaces(std::vector<Surface>& surfaces, const std::array<double, 2>& range, int steps) {
  for (Surface& s : surfaces) s.value += 0.01 * steps * (range[1] - range[0]);
}

} // namespace viewer
