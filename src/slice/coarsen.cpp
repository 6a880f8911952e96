// SPDX-License-Identifier: Apache-2.0
// Averages a slice onto the lattice of twice the distance, axis by axis and brick by brick, and filters the
// result back to coefficients.
#include "slice/coarsen.h"

#include <algorithm>
#include <cmath>

#include "field/coefficients/coefficients.h"
#include "field/footprint/dense_sites.h"
#include "field/footprint/hole.h"
#include "points/sample_source.h"
#include "slice/largest_magnitude.h"
#include "slice/time_slice.h"

namespace bccsplat {
namespace {

constexpr int taps = 4; // of a cubic B-spline
// Coefficients below this part of the largest are dropped, which leaves fewer points to draw, for an error
// below that of a byte.
constexpr float dropped_part = 1.0f / 4096;

// The sites of a coset that a new site averages along one axis.
struct Average {
  int32_t first = 0;
  std::array<float, taps> weight{};
};

// x is the new site, counted in sites of the coset.
Average average_at(double x, bool bcc) {
  Average a;
  const double below = std::floor(x), f = x - below;
  a.first = static_cast<int32_t>(below) - 1;
  if (bcc) {
    const double g = 1 - f;
    a.weight = {static_cast<float>(g * g * g / 6), static_cast<float>((4 - 6 * f * f + 3 * f * f * f) / 6),
                static_cast<float>((4 - 6 * g * g + 3 * g * g * g) / 6), static_cast<float>(f * f * f / 6)};
  } else {
    for (int t = 0; t < taps; ++t)
      a.weight[t] = static_cast<float>(std::max(0.0, 0.5 - 0.25 * std::fabs(t - 1 - f)));
  }
  return a;
}

// Adds `scale` times the averages of an old coset to a brick of a new one.
class Averager {
 public:
  // `ratio` is the new plane distance in old ones.
  Averager(const Lattice3& lattice, const Vec3& ratio) : bcc_(lattice.bcc), ratio_(ratio) {}

  void add(const BrickLayer& from, const BrickLayer& to, const Int3& brick, float scale, float* out) {
    std::array<std::array<Average, brick_edge>, 3> average;
    SiteBox box;
    Int3 count;
    for (size_t a = 0; a < 3; ++a) {
      count[a] = std::min(brick_edge, to.dims()[a] - brick[a] * brick_edge);
      for (int i = 0; i < count[a]; ++i) {
        const double plane =
            ratio_[a] * (bcc_ ? 2 * (brick[a] * brick_edge + i) + to.coset() : brick[a] * brick_edge + i);
        average[a][i] = average_at(bcc_ ? (plane - from.coset()) / 2 : plane, bcc_);
      }
      box.origin[a] = average[a][0].first;
      box.size[a] = average[a][count[a] - 1].first + taps - box.origin[a];
    }
    const size_t nx = box.size[0], ny = box.size[1], nz = box.size[2];
    dense_.resize(nx * ny * nz);
    if (!gather_box(from, box, dense_.data())) return;
    constexpr size_t edge = brick_edge;
    along_x_.assign(edge * ny * nz, 0), along_y_.assign(edge * edge * nz, 0);
    for (size_t row = 0; row < ny * nz; ++row)
      for (size_t i = 0; i < static_cast<size_t>(count[0]); ++i) {
        const Average& a = average[0][i];
        const float* in = dense_.data() + row * nx + (a.first - box.origin[0]);
        along_x_[row * edge + i] =
            a.weight[0] * in[0] + a.weight[1] * in[1] + a.weight[2] * in[2] + a.weight[3] * in[3];
      }
    // Adds weighted sums of four rows of n floats.
    const auto combine = [](const Average& a, const float* in, size_t n, float factor, float* result) {
      for (size_t i = 0; i < n; ++i)
        result[i] += factor * (a.weight[0] * in[i] + a.weight[1] * in[i + n] + a.weight[2] * in[i + 2 * n] +
                               a.weight[3] * in[i + 3 * n]);
    };
    for (size_t z = 0; z < nz; ++z)
      for (size_t j = 0; j < static_cast<size_t>(count[1]); ++j) {
        const Average& a = average[1][j];
        combine(a, along_x_.data() + (z * ny + (a.first - box.origin[1])) * edge, edge, 1,
                along_y_.data() + (z * edge + j) * edge);
      }
    for (size_t k = 0; k < static_cast<size_t>(count[2]); ++k) {
      const Average& a = average[2][k];
      combine(a, along_y_.data() + (a.first - box.origin[2]) * edge * edge, edge * edge, scale,
              out + k * edge * edge);
    }
  }

 private:
  bool bcc_;
  Vec3 ratio_;
  std::vector<float> dense_, along_x_, along_y_;
};

// Returns the holes of a new brick; null when there are none.
std::unique_ptr<BrickMask> find_holes(const Slice& slice, const Lattice3& coarse, const Vec3& ratio,
                                      const BrickLayer& to, const Int3& brick) {
  auto mask = std::make_unique<BrickMask>();
  bool any = false;
  for (int s = 0; s < brick_sites; ++s) {
    const Int3 i{brick[0] * brick_edge + s % brick_edge, brick[1] * brick_edge + s / brick_edge % brick_edge,
                 brick[2] * brick_edge + s / brick_rows};
    Vec3 p;
    bool inside = true;
    for (size_t a = 0; a < 3; ++a) {
      inside = inside && i[a] < to.dims()[a];
      p[a] = coarse.plane_distance() * coarse.plane(to.coset(), i[a]) * ratio[a];
    }
    if (!inside || !slice.is_hole(p)) continue;
    (*mask)[s / brick_edge] |= static_cast<uint16_t>(1u << (s % brick_edge));
    any = true;
  }
  return any ? std::move(mask) : nullptr;
}

} // namespace

Slice coarsen(const Slice& slice, const Context& context) {
  Lattice4 lattice;
  lattice.kind = slice.lattice.bcc ? LatticeKind::bcc : LatticeKind::cc;
  lattice.space.bcc = slice.lattice.bcc;
  lattice.time_step = 0;
  lattice.last_layer = slice.lattice.cosets() - 1;
  Vec3 ratio;
  for (size_t a = 0; a < 3; ++a) {
    lattice.space.periodic[a] = slice.lattice.periodic[a];
    const int32_t period = lattice.space.bcc ? 2 : 1, planes = slice.lattice.planes(a);
    lattice.space.last[a] = slice.lattice.periodic[a]
                                ? std::max(2, (planes + 2 * period - 1) / (2 * period) * period) - 1
                                : (slice.lattice.last[a] + 1) / 2;
    ratio[a] = static_cast<double>(slice.lattice.end_plane(a)) / lattice.space.end_plane(a);
    lattice.dims[a] = lattice.space.last[a] + 1;
  }

  std::vector<BrickLayer> layers;
  float most = 0;
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    BrickLayer layer(lattice.space, c);
    std::vector<std::shared_ptr<Brick>> made(layer.brick_slots());
    context.tasks.parallel_for(made.size(), [&](uint64_t slot) {
      context.progress.check();
      const Int3 brick = layer.slot_position(slot);
      auto b = std::make_shared<Brick>();
      Averager averager(slice.lattice, ratio);
      for (int from = 0; from < slice.lattice.cosets(); ++from)
        averager.add(slice.coset[from], layer, brick, slice.lattice.bcc ? 0.5f : 1.0f, b->value.data());
      if (slice.has_holes && !slice.mask) b->hole = find_holes(slice, lattice.space, ratio, layer, brick);
      if (b->keep_above(0) > 0 || b->hole) made[slot] = std::move(b);
    });
    for (size_t slot = 0; slot < made.size(); ++slot) layer.set(slot, std::move(made[slot]));
    most = std::max(most, largest_magnitude(layer));
    layers.push_back(std::move(layer));
  }

  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  const MemorySamples samples(lattice, {slice.base}, std::move(channels));
  const Coefficients coefficients(samples, 0, slice.kernel, most * dropped_part, UINT64_MAX);
  Slice coarse = time_slice(coefficients, 0, {0, 0}, slice.slice_to_world, context);
  coarse.lattice_to_slice = slice.lattice_to_slice;
  for (Vec3& row : coarse.lattice_to_slice.linear)
    for (size_t a = 0; a < 3; ++a) row[a] *= ratio[a];
  for (size_t a = 0; a < 3; ++a) {
    coarse.domain_begin[a] = slice.domain_begin[a] / ratio[a];
    coarse.domain_end[a] = slice.domain_end[a] / ratio[a];
  }
  for (const HalfSpace& h : slice.clip) {
    const Vec3 normal{h.normal[0] * ratio[0], h.normal[1] * ratio[1], h.normal[2] * ratio[2]};
    const double scale = length(h.normal) / length(normal);
    coarse.clip.push_back({scale * normal, scale * h.offset});
  }
  coarse.hyperplane = slice.hyperplane, coarse.origin = slice.origin, coarse.basis = slice.basis;
  coarse.frame = slice.frame;
  coarse.air = slice.air;
  coarse.mask = slice.mask;
  coarse.holes_by_mask = slice.mask && !coarse.has_holes;
  coarse.has_holes = coarse.has_holes || slice.mask;
  return coarse;
}

} // namespace bccsplat
