#include "slice/plane_slice.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "kernel/cc_kernel.h"
#include "points/sample_source.h"
#include "slice/evaluate.h"
#include "slice/patch.h"

namespace bccsplat {
namespace {

double dot4(const Vec4& a, const Vec4& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]; }

// The coordinate axes without the one closest to the normal, projected onto the hyperplane and
// orthonormalised.
std::array<Vec4, 3> plane_basis(const Vec4& normal) {
  size_t left_out = 0;
  for (size_t a = 1; a < 4; ++a)
    if (std::fabs(normal[a]) > std::fabs(normal[left_out])) left_out = a;
  std::array<Vec4, 3> basis;
  size_t count = 0;
  for (size_t a = 0; a < 4; ++a) {
    if (a == left_out) continue;
    Vec4 v{};
    v[a] = 1;
    // Twice: the second pass removes what rounding left of the first.
    for (int pass = 0; pass < 2; ++pass) {
      const double along = dot4(v, normal);
      for (size_t i = 0; i < 4; ++i) v[i] -= along * normal[i];
      for (size_t k = 0; k < count; ++k) {
        const double part = dot4(v, basis[k]);
        for (size_t i = 0; i < 4; ++i) v[i] -= part * basis[k][i];
      }
      const double length = std::sqrt(dot4(v, v));
      for (double& c : v) c /= length;
    }
    basis[count++] = v;
  }
  return basis;
}

struct Extent {
  Vec3 low{}, high{};
  Vec4 box_low{}, box_high{}; // of the hyperplane's part of the domain, index space
  bool empty = true;
};

// Slice-space bounding box of the domain's part in the hyperplane: the edges of the 4D box that cross it, and
// the corners that lie on it.
Extent plane_extent(const Lattice4& lattice, const std::array<double, 5>& h, const Vec4& origin,
                    const std::array<Vec4, 3>& basis) {
  Extent e;
  const auto include = [&](const Vec4& p) {
    Vec4 d;
    for (size_t i = 0; i < 4; ++i) d[i] = p[i] - origin[i];
    for (size_t k = 0; k < 3; ++k) {
      const double u = dot4(d, basis[k]);
      e.low[k] = e.empty ? u : std::min(e.low[k], u);
      e.high[k] = e.empty ? u : std::max(e.high[k], u);
    }
    for (size_t i = 0; i < 4; ++i) {
      e.box_low[i] = e.empty ? p[i] : std::min(e.box_low[i], p[i]);
      e.box_high[i] = e.empty ? p[i] : std::max(e.box_high[i], p[i]);
    }
    e.empty = false;
  };
  const auto height = [&](const Vec4& p) {
    return h[0] * p[0] + h[1] * p[1] + h[2] * p[2] + h[3] * p[3] + h[4];
  };
  for (unsigned corner = 0; corner < 16; ++corner)
    for (size_t axis = 0; axis < 4; ++axis) {
      if (corner >> axis & 1) continue;
      Vec4 p{};
      for (size_t i = 0; i < 4; ++i) p[i] = (corner >> i & 1) ? lattice.dims[i] - 1.0 : 0;
      Vec4 q = p;
      q[axis] = lattice.dims[axis] - 1.0;
      double from = height(p), to = height(q);
      const double slack = 1e-9;
      if (std::fabs(from) <= slack) include(p);
      if (std::fabs(to) <= slack) include(q);
      if ((from < -slack && to > slack) || (from > slack && to < -slack)) {
        p[axis] = q[axis] * (from / (from - to));
        include(p);
      }
    }
  return e;
}

// How far, in index units per axis, values at a point depend on samples: kernel and prefilter, and a site for
// mirrors.
double reach_in_space(const Kernel& kernel) {
  return kernel.space.radius + (prefilter_reach(kernel.prefilter4).space + 2) / std::numbers::sqrt2;
}

// The bricks that hold all samples in reach of the box.
BrickBox bricks_around(const Lattice4& lattice, const Vec4& low, const Vec4& high, double reach) {
  BrickBox box;
  const Vec3 unit = lattice.lattice_unit();
  for (size_t a = 0; a < 3; ++a) {
    const double pitch = coset_pitch(lattice.space) * unit[a], r = reach * unit[a];
    box.begin[a] = std::max(0, static_cast<int32_t>(std::floor((low[a] - r) / pitch)) - 1) / brick_edge;
    box.end[a] = (static_cast<int32_t>(std::ceil((high[a] + r) / pitch)) + 1) / brick_edge + 1;
  }
  return box;
}

// Lengths and angles of the slice's directions in the volume's world as an affine: the Cholesky factor of
// their Gram matrix under the metric (affine^T affine, time_length^2).
Affine3 display_affine(const std::array<Vec4, 3>& basis, const Affine3& index_to_world, double time_length) {
  std::array<Vec4, 3> world;
  for (size_t k = 0; k < 3; ++k) {
    const Vec3 v = index_to_world.vector({basis[k][0], basis[k][1], basis[k][2]});
    world[k] = {v[0], v[1], v[2], time_length * basis[k][3]};
  }
  Affine3 a;
  for (size_t k = 0; k < 3; ++k) a.linear[k] = {};
  for (size_t col = 0; col < 3; ++col)
    for (size_t row = 0; row <= col; ++row) {
      double s = dot4(world[row], world[col]);
      for (size_t k = 0; k < row; ++k) s -= a.linear[k][row] * a.linear[k][col];
      a.linear[row][col] = row == col ? std::sqrt(std::max(s, 0.0)) : s / a.linear[row][row];
    }
  return a;
}

} // namespace

Slice plane_slice(const Coefficients& coefficients, const std::array<double, 5>& h,
                  const PlaneOptions& options, const Affine3& index_to_world, const Context& context) {
  const auto start = std::chrono::steady_clock::now();
  const Lattice4& lattice = coefficients.source().lattice();
  if (lattice.is_static()) fail(Code::unsupported, "a static volume has no hyperplanes but its time slice");
  if (!(options.spacing > 0 && std::isfinite(options.spacing) && options.time_length > 0 &&
        std::isfinite(options.time_length)))
    fail(Code::invalid_argument, "plane slice: spacing and time length must be positive");

  if (options.target == LatticeKind::d4star)
    fail(Code::invalid_argument, "plane slice: the target lattice is BCC or CC");

  Slice slice;
  const bool bcc = options.target == LatticeKind::bcc;
  slice.kernel = coefficients.kernel();
  if (bcc != lattice.space.bcc) // the same kernel's form for the other lattice
    slice.kernel = bcc ? make_kernel(slice.kernel.name) : make_cc_kernel(slice.kernel.name).kernel;
  slice.air = coefficients.air();
  slice.hyperplane = h;
  const Vec4 normal{h[0], h[1], h[2], h[3]};
  for (size_t i = 0; i < 4; ++i) slice.origin[i] = -h[4] * normal[i];
  slice.basis = plane_basis(normal);
  slice.slice_to_world = display_affine(slice.basis, index_to_world, options.time_length);
  const Extent extent = plane_extent(lattice, h, slice.origin, slice.basis);

  // The target lattice as a static volume of its own: mirrored at the ends of the bounding box, stretched to
  // fit.
  Lattice4 target;
  target.kind = options.target;
  target.space.bcc = bcc;
  target.time_step = 0;
  target.last_layer = target.space.cosets() - 1;
  const double distance = options.spacing * target.space.plane_distance();
  for (size_t a = 0; a < 3; ++a) {
    const double size = extent.high[a] - extent.low[a];
    const double planes = std::ceil(size / distance - 1e-9);
    if (!(planes < 1e6))
      fail(Code::limit_exceeded, "plane slice: more than 1e6 planes along an axis; raise the spacing");
    target.space.last[a] = std::max(1, static_cast<int32_t>(planes));
    target.space_step[a] = size > 0 ? size / target.space.last[a] : distance;
    target.dims[a] = static_cast<uint32_t>(target.space.last[a]) + 1; // planes; only 1 or more matters here
  }
  slice.lattice = target.space;
  const Vec3 unit = target.lattice_unit();
  for (size_t a = 0; a < 3; ++a) {
    slice.lattice_to_slice.linear[a] = {};
    slice.lattice_to_slice.linear[a][a] = unit[a];
    slice.lattice_to_slice.offset[a] = extent.low[a];
    slice.domain_end[a] = (extent.high[a] - extent.low[a]) / unit[a];
  }
  for (int c = 0; c < slice.lattice.cosets(); ++c)
    slice.coset[static_cast<size_t>(c)] = BrickLayer(slice.lattice, c);
  slice.bounds = {slice.air, slice.air};
  if (extent.empty) return slice;

  // Position of lattice point p (lattice units) on index axis i: at[i] + dot(along[i], p).
  std::array<Vec3, 4> along;
  Vec4 at = slice.origin;
  for (size_t i = 0; i < 4; ++i)
    for (size_t k = 0; k < 3; ++k) {
      along[i][k] = slice.basis[k][i] * unit[k];
      at[i] += slice.basis[k][i] * extent.low[k];
    }
  for (size_t i = 0; i < 4; ++i) { // the faces of the domain that cut the bounding box
    const double end = lattice.dims[i] - 1.0;
    const auto add = [&](const Vec3& n, double offset) {
      double lowest = offset;
      for (size_t k = 0; k < 3; ++k) lowest += std::min(0.0, n[k] * slice.domain_end[k]);
      if (lowest < -1e-6) slice.clip.push_back({n, offset});
    };
    add(along[i], at[i]);
    add(-1.0 * along[i], end - at[i]);
  }

  // Only what the plane's reach touches is read; sites further outside the domain than the 3D filter and
  // kernel reach stay air.
  const double reach = reach_in_space(coefficients.kernel());
  const Coefficients local(coefficients.source(), coefficients.channel(), coefficients.kernel(),
                           coefficients.prune(), coefficients.cache_bytes(),
                           bricks_around(lattice, extent.box_low, extent.box_high, reach));
  const double margin =
      slice.kernel.space.radius + (prefilter_reach(slice.kernel.prefilter3).space + 2) / std::numbers::sqrt2;
  const auto needed = [&](const Vec4& p) {
    for (size_t i = 0; i < 4; ++i)
      if (p[i] < -margin || p[i] > lattice.dims[i] - 1.0 + margin) return false;
    return true;
  };
  std::vector<BrickLayer> samples;
  for (int c = 0; c < target.space.cosets(); ++c) {
    BrickLayer layer(target.space, c);
    const Int3 n = layer.dims(), bricks = layer.brick_dims();
    // A sheet of bricks at a time: its points lie close together in time for axis slices.
    for (int bz = 0; bz < bricks[2]; ++bz) {
      std::vector<Vec4> points;
      std::vector<std::pair<uint32_t, uint16_t>> place; // brick slot, site
      for (int by = 0; by < bricks[1]; ++by)
        for (int bx = 0; bx < bricks[0]; ++bx)
          for (int s = 0; s < brick_sites; ++s) {
            const Int3 i{bx * brick_edge + s % brick_edge, by * brick_edge + s / brick_edge % brick_edge,
                         bz * brick_edge + s / brick_rows};
            if (i[0] >= n[0] || i[1] >= n[1] || i[2] >= n[2]) continue;
            const Vec3 p = slice.site(c, i);
            Vec4 q;
            for (size_t k = 0; k < 4; ++k) q[k] = at[k] + dot(along[k], p);
            if (!needed(q)) continue;
            points.push_back(q);
            place.emplace_back(static_cast<uint32_t>(layer.slot(bx, by, bz)), static_cast<uint16_t>(s));
          }
      std::vector<float> values(points.size());
      std::vector<uint8_t> holes(points.size());
      evaluate4_mirrored(local, points, values, {}, holes, context);
      for (size_t first = 0, last; first < points.size(); first = last) {
        auto brick = std::make_shared<Brick>();
        for (last = first; last < points.size() && place[last].first == place[first].first; ++last) {
          brick->value[place[last].second] = values[last];
          if (!holes[last]) continue;
          if (!brick->hole) brick->hole = std::make_unique<BrickMask>();
          auto& row = (*brick->hole)[place[last].second / brick_edge];
          row = static_cast<uint16_t>(row | 1u << place[last].second % brick_edge);
          slice.has_holes = true;
        }
        if (brick->keep_above(0) > 0 || brick->hole) layer.set(place[first].first, std::move(brick));
      }
    }
    samples.push_back(std::move(layer));
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(samples));
  const MemorySamples memory(target, {slice.air}, std::move(channels));
  const Coefficients filtered(memory, 0, slice.kernel, coefficients.prune(),
                              std::numeric_limits<uint64_t>::max());
  for (int c = 0; c < target.space.cosets(); ++c)
    slice.coset[static_cast<size_t>(c)] = *filtered.layer(c, context);
  slice.bounds = coefficient_bounds(slice);
  slice.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return slice;
}

} // namespace bccsplat
