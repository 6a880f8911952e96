// SPDX-License-Identifier: Apache-2.0
// Planes and layers: how many there are at a distance, and which of them stands for one beyond the ends.
#include "lattice/lattice.h"

#include <algorithm>
#include <cmath>

#include "base/cube_root.h"
#include "base/error.h"

namespace bccsplat {
namespace {

// Folds a plane number into [0, last] by mirroring at both ends.
int32_t fold(int64_t h, int64_t last) {
  const int64_t period = 2 * last;
  h %= period;
  if (h < 0) h += period;
  return static_cast<int32_t>(h <= last ? h : period - h);
}

// The first plane at or beyond `end` when planes are `distance` apart; a rounding error makes no further
// plane.
int32_t planes_to(double end, double distance) {
  const double planes = std::ceil(end / distance - 1e-9);
  if (!(planes < 1e9)) fail(Code::limit_exceeded, "more than 1e9 planes of the lattice along one axis");
  return std::max(1, static_cast<int32_t>(planes));
}

} // namespace

int32_t Lattice3::mirror(size_t axis, int coset, int32_t i) const {
  if (periodic[axis]) {
    const int32_t sites = dims(coset)[axis], turned = i % sites;
    return turned < 0 ? turned + sites : turned;
  }
  if (!bcc) return fold(i, last[axis]);
  return (fold(2 * int64_t{i} + coset, last[axis]) - coset) / 2;
}

Lattice4 Lattice4::fit(LatticeKind kind, const std::array<uint32_t, 4>& dims, const LatticeScales& scales,
                       int32_t lead, const Int3& margins, bool periodic, const AxisFlags& turning) {
  for (const uint32_t n : dims)
    if (n == 0) fail(Code::invalid_argument, "dims: every one must be at least 1");
  constexpr double most = 65536; // filters are as wide
  for (const double scale : scales)
    if (!(scale > 0 && scale <= most))
      fail(Code::invalid_argument, "scales: lattice distances must be positive and at most ", most);
  Lattice4 l;
  l.kind = kind;
  l.dims = dims;
  l.space.bcc = kind != LatticeKind::cc;
  for (size_t a = 0; a < 3; ++a) {
    const double end = dims[a] - 1.0, distance = scales[a] * l.space.plane_distance();
    if (turning[a]) {
      if (dims[a] < 2 || margins[a] > 0)
        fail(Code::invalid_argument, "periodic_axes: such an axis has two samples at least and no faces");
      const int32_t period = l.space.bcc ? 2 : 1, turns = planes_to(dims[a], distance * period);
      l.space.periodic[a] = true;
      l.space.last[a] = std::max(2, turns * period) - 1;
      l.space_step[a] = static_cast<double>(dims[a]) / l.space.planes(a);
      continue;
    }
    const int32_t inner = planes_to(end, distance);
    l.space_step[a] = end > 0 ? end / inner : distance;
    l.before[a] = l.behind[a] = margins[a];
    l.space.last[a] = inner + 2 * margins[a];
  }
  if (dims[3] == 1) {
    if (kind == LatticeKind::d4star) l.kind = LatticeKind::bcc;
    l.time_step = 0;
    l.last_layer = l.space.cosets() - 1;
  } else {
    if (kind == LatticeKind::bcc) l.kind = LatticeKind::d4star;
    l.time_step = scales[3] * l.space.plane_distance();
    if (periodic) {
      const int32_t period = l.layer_period(), turns = planes_to(dims[3], l.time_step * period);
      l.periodic = true;
      l.last_layer = std::max(2, turns * period) - 1;
      l.time_step = static_cast<double>(dims[3]) / l.layers();
    } else {
      l.lead = lead;
      l.last_layer = planes_to(dims[3] - 1.0, l.time_step) + 2 * lead;
    }
  }
  return l;
}

int32_t Lattice4::mirror_layer(int32_t layer) const {
  if (is_static()) return space.bcc ? layer & 1 : 0;
  if (!periodic) return fold(layer, last_layer);
  const int32_t turned = layer % layers();
  return turned < 0 ? turned + layers() : turned;
}

int64_t Lattice4::nearest_frame(double frame) const {
  const double near = std::floor(frame + 0.5);
  if (periodic) return turned_frame(static_cast<int64_t>(near));
  return static_cast<int64_t>(std::clamp(near, 0.0, dims[3] - 1.0));
}

LatticeScales Lattice4::nominal_scales() const {
  LatticeScales s = scales();
  for (size_t a = 0; a < 3; ++a)
    if (s[a] < 1 && s[a] > 1 - (turns(a) && space.bcc ? 2.0 : 1.0) / inner_planes(a)) s[a] = 1;
  if (periodic && s[3] < 1 && s[3] > 1 - 1.0 * layer_period() / layers()) s[3] = 1;
  return s;
}

int64_t Lattice4::sites_outside(int32_t begin, int32_t end) const {
  Lattice3 inner = space;
  for (size_t a = 0; a < 3; ++a) inner.last[a] -= before[a] + behind[a];
  int64_t sites = 0;
  for (int c = 0; c < space.cosets(); ++c) { // layers of a coset are alike
    const int32_t first = begin + ((c - begin) & (layer_period() - 1));
    if (first < end)
      sites += (int64_t{end - first - 1} / layer_period() + 1) * (space.sites(c) - inner.sites(c));
  }
  return sites;
}

int64_t Lattice4::sites() const {
  const int64_t even = space.sites(0);
  if (!space.bcc) return even * layers();
  const int64_t odd_layers = layers() / 2;
  return even * (layers() - odd_layers) + space.sites(1) * odd_layers;
}

bool Lattice4::sites_are_samples() const {
  if (space.bcc || has_margins() || time_step != (dims[3] > 1 ? 1 : 0)) return false;
  for (size_t a = 0; a < 3; ++a)
    if (dims[a] > 1 && space_step[a] != 1) return false;
  return true;
}

double mean_in_space(const LatticeScales& scales) {
  const auto& [x, y, z, t] = scales;
  return x == y && y == z ? x : cube_root(x * y * z);
}

} // namespace bccsplat
