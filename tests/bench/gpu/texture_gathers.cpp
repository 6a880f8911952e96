// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gpu/texture_gathers.h"

#include <array>
#include <cstdio>

namespace bccsplat::bench {
namespace {

std::string vec3_text(const Vec3& v) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "vec3(%.9g,%.9g,%.9g)", v[0], v[1], v[2]);
  return text.data();
}

const char* const trilinear =
    "float tap(vec3 q) { return textureLod(sites, q * OVER_SIZE, 0.0).r; } "
    "Sum gather(vec3 p) { vec3 q = p * SCALE + OFFSET; const vec2 h = vec2(1.0, 0.0); "
    "vec3 slope = 0.5 * vec3(tap(q + h.xyy) - tap(q - h.xyy), tap(q + h.yxy) - tap(q - h.yxy), "
    "tap(q + h.yyx) - tap(q - h.yyx)); "
    "return Sum(tap(q), slope * SCALE, 1.0, vec3(0.0)); }";

// Of each axis two pairs of weights, w the values' and g the slopes', and where each pair's sample is taken.
const char* const tricubic =
    "float tap(vec3 q) { return textureLod(sites, q * OVER_SIZE, 0.0).r; } "
    "float eight(vec3 a, vec3 b, vec3 u, vec3 v) { return "
    "u.z * (u.y * (u.x * tap(a) + v.x * tap(vec3(b.x, a.yz))) + v.y * (u.x * tap(vec3(a.x, b.y, a.z)) + v.x "
    "* "
    "tap(vec3(b.xy, a.z)))) + "
    "v.z * (u.y * (u.x * tap(vec3(a.xy, b.z)) + v.x * tap(vec3(b.x, a.y, b.z))) + v.y * (u.x * tap(vec3(a.x, "
    "b.yz)) + v.x * tap(b))); } "
    "Sum gather(vec3 p) { vec3 q = p * SCALE + OFFSET - 0.5; vec3 i = floor(q), f = q - i, e = 1.0 - f; "
    "vec3 w0 = e * e * e / 6.0, w3 = f * f * f / 6.0, w1 = 2.0 / 3.0 - 0.5 * f * f * (2.0 - f), "
    "w2 = 2.0 / 3.0 - 0.5 * e * e * (2.0 - e); "
    "vec3 g0 = -0.5 * e * e, g3 = 0.5 * f * f, g1 = 0.5 * f * (3.0 * f - 4.0), g2 = -0.5 * e * (3.0 * e - "
    "4.0); "
    "vec3 u = w0 + w1, v = w2 + w3, a = i - 0.5 + w1 / u, b = i + 1.5 + w3 / v; "
    "vec3 gu = g0 + g1, gv = g2 + g3, ga = i - 0.5 + g1 / gu, gb = i + 1.5 + g3 / gv; "
    "float x = eight(vec3(ga.x, a.yz), vec3(gb.x, b.yz), vec3(gu.x, u.yz), vec3(gv.x, v.yz)), "
    "y = eight(vec3(a.x, ga.y, a.z), vec3(b.x, gb.y, b.z), vec3(u.x, gu.y, u.z), vec3(v.x, gv.y, v.z)), "
    "z = eight(vec3(a.xy, ga.z), vec3(b.xy, gb.z), vec3(u.xy, gu.z), vec3(v.xy, gv.z)); "
    "return Sum(eight(a, b, u, v), vec3(x, y, z) * SCALE, 1.0, vec3(0.0)); }";

void replace(std::string& text, const std::string& name, const std::string& by) {
  for (size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += by.size())
    text.replace(at, name.size(), by);
}

} // namespace

std::string texture_gather(const MarchGrid& grid, const Slice& slice) {
  const Affine3& m = slice.lattice_to_slice;
  std::string text = grid.interpolation == Interpolation::tricubic ? tricubic : trilinear;
  const double border = MarchGrid::pad + 0.5; // the middle of texel 0 is at 0.5
  const auto size = [&](size_t a) { return 1.0 / (grid.dims[a] + 2 * MarchGrid::pad); };
  replace(text, "SCALE", vec3_text({m.linear[0][0], m.linear[1][1], m.linear[2][2]}));
  replace(text, "OFFSET", vec3_text({m.offset[0] + border, m.offset[1] + border, m.offset[2] + border}));
  replace(text, "OVER_SIZE", vec3_text({size(0), size(1), size(2)}));
  return text;
}

} // namespace bccsplat::bench
