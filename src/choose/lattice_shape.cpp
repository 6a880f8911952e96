// SPDX-License-Identifier: Apache-2.0
// Counts the planes and layers that a writer will make of a shape, rounding as it does, and derives from them
// distances, densities and the shape of a part.
#include "choose/lattice_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "series/library.h"
#include "series/text.h"

namespace bccsplat::series {
namespace {

constexpr double kSameSteps = 1e-9;

// Is a whole number of layers, or of planes, a turn of n samples?
bool turns(const LatticeShape& s, size_t axis, uint64_t n) {
  return n > 1 && (axis == 3 ? s.ends == BCCSPLAT_ENDS_PERIODIC : is_periodic(s.periodic, axis));
}

// Returns the distance of planes in units of the lattice's distance.
double plane_distance(const LatticeShape& s) { return is_bcc(s) ? 1 / std::numbers::sqrt2 : 1; }

double axes_of(const std::array<uint64_t, 4>& dims) {
  return static_cast<double>(std::count_if(dims.begin(), dims.end(), [](uint64_t n) { return n > 1; }));
}

// Distances of `lattice` at a density when all are alike.
double even_distance(int32_t lattice, double density, const std::array<uint64_t, 4>& dims) {
  const double axes = axes_of(dims);
  // Sites in a cube of the distance: 2 to a cell of sqrt2 times it.
  const double sites = lattice == BCCSPLAT_LATTICE_CC ? 1 : 2 / std::pow(std::numbers::sqrt2, axes);
  return axes > 0 ? std::pow(sites / density, 1 / axes) : 1;
}

} // namespace

bool is_bcc(const LatticeShape& s) { return s.lattice != BCCSPLAT_LATTICE_CC; }

bool has_source_planes(const LatticeShape& s) {
  return !is_bcc(s) &&
         std::all_of(s.scales.begin(), s.scales.begin() + 3, [](double scale) { return scale == 1; });
}

bool has_source_frames(const LatticeShape& s) { return !is_bcc(s) && s.scales[3] == 1; }

double last_plane(const LatticeShape& s, size_t axis, uint64_t n) {
  if (turns(s, axis, n)) {
    const double period = is_bcc(s) ? 2 : 1;
    return std::max(2.0, period * std::ceil(static_cast<double>(n) /
                                                (period * s.scales[axis] * plane_distance(s)) -
                                            kSameSteps)) -
           1;
  }
  return std::max(1.0,
                  std::ceil(static_cast<double>(n - 1) / (s.scales[axis] * plane_distance(s)) - kSameSteps));
}

bool is_source_grid(const LatticeShape& s) { return has_source_planes(s) && has_source_frames(s); }

Distances realised_distances(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  Distances d = s.scales; // along time exact: a series may go on
  for (size_t a = 0; a < 3; ++a)
    if (dims[a] > 1) d[a] = static_cast<double>(dims[a] - 1) / last_plane(s, a, dims[a]) / plane_distance(s);
  for (size_t a = 0; a < 4; ++a)
    if (turns(s, a, dims[a]))
      d[a] = static_cast<double>(dims[a]) / (last_plane(s, a, dims[a]) + 1) / plane_distance(s);
  return d;
}

LatticeShape shape_of_part(const LatticeShape& shape, const std::array<uint64_t, 4>& dims,
                           const std::array<uint64_t, 4>& part, bool ends_with_series) {
  LatticeShape s = shape;
  const Distances distances = realised_distances(shape, dims);
  for (size_t a = 0; a < 3; ++a)
    if (part[a] != dims[a]) s.periodic &= ~(1 << a);
  for (size_t a = 0; a < 4; ++a) {
    if (part[a] == dims[a] || part[a] == 1 || (a == 3 && !ends_with_series)) continue;
    const double plane = distances[a] * plane_distance(shape);
    double length = static_cast<double>(part[a] - 1);
    if (a == 3) length += last_plane(shape, a, dims[a]) * plane - static_cast<double>(dims[a] - 1);
    s.scales[a] = length / std::max(1.0, std::round(length / plane)) / plane_distance(shape);
  }
  return s;
}

uint64_t inner_layers(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  return dims[3] == 1 ? 1 : static_cast<uint64_t>(last_plane(s, 3, dims[3])) + 1;
}

double site_density(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  const size_t cosets = is_bcc(s) ? 2 : 1;
  double sites = 0, samples = 1;
  for (size_t c = 0; c < cosets; ++c) {
    double of_coset = 1;
    for (size_t a = 0; a < 4; ++a) {
      if (a == 3 && dims[a] == 1) continue;
      of_coset *=
          std::floor((last_plane(s, a, dims[a]) - static_cast<double>(c)) / static_cast<double>(cosets)) + 1;
    }
    sites += of_coset;
  }
  for (const uint64_t n : dims) samples *= static_cast<double>(n);
  return sites / samples;
}

LatticeShape cubic_lattice(int32_t lattice, double density, const std::array<uint64_t, 4>& dims) {
  LatticeShape s{lattice, {1, 1, 1, 1}};
  double distance = even_distance(lattice, density, dims);
  if (std::fabs(distance - 1) < kSameSteps) distance = 1;
  for (size_t a = 0; a < 4; ++a)
    if (dims[a] > 1) s.scales[a] = distance;
  return s;
}

LatticeShape scaled_shape(LatticeShape shape, double fewer, const std::array<uint64_t, 4>& dims) {
  const double factor = std::pow(fewer, 1 / std::max(1.0, axes_of(dims)));
  for (size_t a = 0; a < 4; ++a)
    if (dims[a] > 1) shape.scales[a] *= factor;
  return shape;
}

std::string shape_text(const LatticeShape& shape, const std::array<uint64_t, 4>& dims) {
  const Distances d = realised_distances(shape, dims);
  std::string text = concat(lattice_name(shape.lattice), ", distances");
  for (size_t a = 0; a < (dims[3] > 1 ? 4 : 3); ++a)
    text += concat(a == 0 ? " " : " x ", short_number(d[a], 3));
  if (shape.faces == BCCSPLAT_FACES_PREDICT || shape.ends == BCCSPLAT_ENDS_PREDICT)
    text += ", ends predicted";
  for (size_t a = 0; a < 3; ++a)
    if (turns(shape, a, dims[a])) text += concat(", periodic along ", "xyz"[a]);
  if (turns(shape, 3, dims[3])) text += ", periodic in time";
  return text;
}

} // namespace bccsplat::series
