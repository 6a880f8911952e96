// SPDX-License-Identifier: Apache-2.0
// Resamples the 4D field on a lattice in the hyperplane: reads what is in reach, evaluates the field at the
// sites that can differ from the base of the field, and filters these samples to coefficients.
#include "slice/plane_slice.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "field/evaluate.h"
#include "field/footprint/patch.h"
#include "kernel/cc_kernel.h"
#include "kernel/kernel_time.h"
#include "points/sample_source.h"
#include "slice/coarser_plane.h"
#include "slice/even_slice.h"
#include "slice/gaussian_mean.h"
#include "slice/layer_weights.h"
#include "slice/occupancy.h"
#include "slice/plane_spacing.h"
#include "slice/thick_field.h"
#include "slice/touched_samples.h"

namespace bccsplat {
namespace {

// The parts of the whole work at which, roughly, the samples are read, the volume's coefficients made, and
// the slice's samples made; filtering these is the rest. Only reports of progress depend on it.
constexpr double read_end = 0.1, make_end = 0.4, sample_end = 0.97;
// A slice of more planes along an axis is a mistake in its spacing.
constexpr double most_planes = 1e6;
// Planes beyond each end of the box around the domain: where faces of the domain bound the box, mirrors right
// at them would bend the field, which the volume's own planes there go on with.
constexpr int planes_outside = 2;
// Samples that are read at once may take one part in so many of the coefficient cache; the rest is for the
// coefficients made of them.
constexpr uint64_t held_part = 4;

// Returns the reach of the volume's kernel in index units and frames.
Vec4 kernel_reach(const Coefficients& coefficients) {
  const Lattice4& lattice = coefficients.source().lattice();
  const Kernel& kernel = coefficients.kernel();
  Vec4 reach;
  for (size_t a = 0; a < 3; ++a) reach[a] = kernel.space.radius * lattice.lattice_unit()[a];
  reach[3] = kernel.time.half_width / kernel_time_per_frame(lattice);
  return reach;
}

// Returns the same of what values are made by.
Vec4 value_reach(const Coefficients& coefficients, const HypersliceOptions& options) {
  const Vec4 kernel = kernel_reach(coefficients);
  if (!options.bandwidth) return kernel;
  Vec4 reach = gaussian_reach(coefficients.source().lattice(), *options.bandwidth);
  for (size_t a = 0; a < 4; ++a) reach[a] = std::max(reach[a], kernel[a]);
  return reach;
}

// The reach is that of the volume's kernel and prefilter, and a site for rounding.
TouchReach touch_reach(const Coefficients& coefficients, double margin, double thickness) {
  const Lattice4& lattice = coefficients.source().lattice();
  const Kernel& kernel = coefficients.kernel();
  Reach filter = prefilter_reach(kernel.prefilter4);
  if (!lattice.space.bcc) filter.time = prefilter_reach(make_cc_kernel(kernel.name).time).time;
  TouchReach reach;
  reach.samples = kernel_reach(coefficients);
  for (size_t a = 0; a < 3; ++a) reach.samples[a] += (filter.space + 1) * lattice.space_step[a];
  reach.samples[3] += (filter.time + 1) * lattice.time_step;
  reach.mirrored.fill(margin);
  reach.half_thickness = thickness / 2;
  return reach;
}

// Returns the bricks that hold all samples in reach of the box.
BrickBox bricks_around(const Lattice4& lattice, const PlaneExtent& extent, const TouchReach& touch) {
  BrickBox box;
  const Vec3 unit = lattice.lattice_unit();
  for (size_t a = 0; a < 3; ++a) {
    const double pitch = coset_pitch(lattice.space) * unit[a], r = touch.samples[a] + touch.half_thickness;
    const double first = lattice.plane_position(a, 0); // site 0 of coset 0
    box.begin[a] =
        std::max(0, static_cast<int32_t>(std::floor((extent.box_low[a] - r - first) / pitch)) - 1) /
        brick_edge;
    box.end[a] =
        (static_cast<int32_t>(std::ceil((extent.box_high[a] + r - first) / pitch)) + 1) / brick_edge + 1;
    // What is beyond the end of a periodic axis lies at the other one.
    const double beyond = r + touch.mirrored[a];
    if (lattice.turns(a) &&
        (extent.box_low[a] < beyond || extent.box_high[a] + beyond > lattice.domain_end(a)))
      box.begin[a] = 0;
  }
  return go_round(box, lattice.space);
}

// What a slice that is not empty reads: the bricks in reach of its hyperplane, in a box around the part of it
// that lies in the domain.
struct PlaneReads {
  double margin; // beyond the ends of the domain
  TouchReach reach;
  BrickBox region;
};

PlaneReads reads_of(const Coefficients& coefficients, const Slice& slice, const PlaneExtent& extent,
                    const HypersliceOptions& options) {
  const Lattice4& lattice = coefficients.source().lattice();
  const Vec3 spacing = plane_spacings(lattice, options, {slice.origin, slice.basis});
  PlaneReads r;
  r.margin = slice_margin(slice, *std::max_element(spacing.begin(), spacing.end()));
  r.reach = touch_reach(coefficients, r.margin, options.thickness.length);
  const Vec4 around = value_reach(coefficients, options);
  for (size_t a = 0; a < 4; ++a) r.reach.samples[a] = std::max(r.reach.samples[a], around[a]);
  if (options.bandwidth) r.reach.mirrored.fill(r.margin + *std::max_element(around.begin(), around.end()));
  r.region = bricks_around(lattice, extent, r.reach);
  return r;
}

// A point p of the target lattice, in lattice units, is at + along * p in index space.
struct Placement {
  Vec4 at;
  std::array<Vec3, 4> along; // per index axis

  explicit Placement(const Slice& slice) : at(slice.origin) {
    for (size_t a = 0; a < 3; ++a)
      for (size_t i = 0; i < 4; ++i) {
        along[i][a] = slice.basis[a][i] * slice.lattice_to_slice.linear[a][a];
        at[i] += slice.basis[a][i] * slice.lattice_to_slice.offset[a];
      }
  }

  [[nodiscard]] Vec4 operator()(const Vec3& p) const {
    Vec4 q;
    for (size_t i = 0; i < 4; ++i) q[i] = at[i] + dot(along[i], p);
    return q;
  }
};

// Returns the faces of the domain that cut the slice's bounding box.
std::vector<HalfSpace> domain_faces(const Lattice4& lattice, const Slice& slice, const Placement& place) {
  std::vector<HalfSpace> faces;
  const auto add = [&](const Vec3& n, double offset) {
    double lowest = offset;
    for (size_t k = 0; k < 3; ++k)
      lowest += std::min(n[k] * slice.domain_begin[k], n[k] * slice.domain_end[k]);
    if (lowest < -1e-6) faces.push_back({n, offset});
  };
  for (size_t i = 0; i < 4; ++i) {
    add(place.along[i], place.at[i]);
    add(-1.0 * place.along[i], lattice.domain_end(i) - place.at[i]);
  }
  return faces;
}

// Decides which sites of the target lattice are evaluated: those near the domain and near coefficients that
// are not 0.
struct Wanted {
  const Lattice4& lattice;    // the volume's
  const Occupancy* occupancy; // null: unknown
  double margin;              // beyond the ends of the domain
  Vec4 reach;                 // of values on coefficients
  const UnevenAxes* even;     // along which points are even positions; null: none

  [[nodiscard]] bool near_domain(const Vec4& p) const {
    for (size_t i = 0; i < 4; ++i)
      if (p[i] < -margin || p[i] > lattice.domain_end(i) + margin) return false;
    return true;
  }
  [[nodiscard]] Vec4 index_of(const Vec4& p) const {
    if (!even) return p;
    const Vec3 space = even->index_of({p[0], p[1], p[2]});
    return {space[0], space[1], space[2], p[3]};
  }
  [[nodiscard]] bool box(const Vec4& centre, const Vec4& half) const {
    if (!occupancy) return true;
    Vec4 low, high;
    for (size_t i = 0; i < 4; ++i)
      low[i] = centre[i] - half[i] - reach[i], high[i] = centre[i] + half[i] + reach[i];
    return occupancy->any(low, high);
  }
};

// Sites that are looked up in the occupancy together: smaller blocks leave out more sites and ask more often.
constexpr int block_edge = 4;
constexpr int brick_blocks = brick_edge / block_edge;

// Returns the axes of a slice, first the one along which it goes through most time: what is sampled at once
// is a stretch of it, which needs few of the volume's layers; where not all of them stay, others are made
// anew.
std::array<size_t, 3> sampled_axes(const Placement& placed, const Int3& bricks) {
  std::array<size_t, 3> axes{2, 1, 0};
  const auto time = [&](size_t a) { return std::fabs(placed.along[3][a]) * bricks[a]; };
  std::stable_sort(axes.begin(), axes.end(), [&](size_t a, size_t b) { return time(a) > time(b); });
  if (axes[1] < axes[2]) std::swap(axes[1], axes[2]);
  return axes;
}

// Returns the slice's samples on one coset of its lattice.
BrickLayer sample_coset(const ThickField& field, Slice& slice, const Lattice4& target, int coset,
                        const Placement& placed, const Wanted& wanted, const Context& context) {
  BrickLayer layer(target.space, coset);
  const Int3 n = layer.dims(), bricks = layer.brick_dims();
  const double half_block = coset_pitch(target.space) * (block_edge - 1) / 2;
  Vec4 half;
  for (size_t i = 0; i < 4; ++i) {
    half[i] = 0;
    for (const double x : placed.along[i]) half[i] += half_block * std::fabs(x);
  }
  // One layer of bricks is sampled at a time, or as many rows of it as the budget has room for at once.
  const auto [across, down, along] = sampled_axes(placed, bricks);
  const auto row_sites = static_cast<uint64_t>(bricks[along]) * brick_sites;
  int rows = bricks[down];
  Reservation memory;
  for (;; rows = (rows + 1) / 2) {
    const uint64_t bytes = rows * row_sites * field.bytes_per_point();
    if (rows > 1 && !context.memory.try_reserve(bytes)) continue;
    memory = rows > 1 ? Reservation::adopt(context.memory, bytes)
                      : Reservation(context.memory, bytes, "samples of an oblique slice");
    break;
  }
  const int parts = (bricks[down] + rows - 1) / rows;
  for (int part = 0; part < bricks[across] * parts; ++part) {
    const int first_row = part % parts * rows;
    std::vector<Vec4> points;
    std::vector<std::pair<uint32_t, uint16_t>> place; // brick slot, site
    points.reserve(rows * row_sites), place.reserve(points.capacity());
    for (int row = first_row; row < std::min(first_row + rows, bricks[down]); ++row)
      for (int b = 0; b < bricks[along]; ++b) {
        Int3 brick{};
        brick[across] = part / parts, brick[down] = row, brick[along] = b;
        const auto [bx, by, bz] = brick;
        std::array<bool, brick_blocks * brick_blocks * brick_blocks> block;
        for (int k = 0; k < static_cast<int>(block.size()); ++k) {
          const Int3 low{bx * brick_edge + k % brick_blocks * block_edge,
                         by * brick_edge + k / brick_blocks % brick_blocks * block_edge,
                         bz * brick_edge + k / (brick_blocks * brick_blocks) * block_edge};
          const Vec3 centre = slice.site(coset, low) + Vec3{half_block, half_block, half_block};
          block[k] = low[0] < n[0] && low[1] < n[1] && low[2] < n[2] && wanted.box(placed(centre), half);
        }
        for (int s = 0; s < brick_sites; ++s) {
          const Int3 local{s % brick_edge, s / brick_edge % brick_edge, s / brick_rows};
          const int k = (local[2] / block_edge * brick_blocks + local[1] / block_edge) * brick_blocks +
                        local[0] / block_edge;
          const Int3 i{bx * brick_edge + local[0], by * brick_edge + local[1], bz * brick_edge + local[2]};
          if (!block[k] || i[0] >= n[0] || i[1] >= n[1] || i[2] >= n[2]) continue;
          const Vec4 q = placed(slice.site(coset, i));
          if (!wanted.near_domain(q)) continue;
          points.push_back(wanted.index_of(q));
          place.emplace_back(static_cast<uint32_t>(layer.slot(bx, by, bz)), static_cast<uint16_t>(s));
        }
      }
    std::vector<float> values(points.size());
    std::vector<uint8_t> holes(points.size());
    const double end = 1.0 * bricks[across] * parts;
    Progress share(context.progress, part / end, (part + 1) / end);
    field.values(points, values, holes, context.with(share));
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
  return layer;
}

// Returns the target lattice as a static volume, stretched to fit the bounding box, and mirrored a little
// beyond its ends.
Lattice4 target_lattice(const Lattice4& lattice, const HypersliceOptions& options, const PlaneAxes& axes,
                        const PlaneExtent& extent) {
  const Vec3 spacing = plane_spacings(lattice, options, axes);
  Lattice4 target;
  target.kind = options.target.value_or(LatticeKind::bcc);
  target.space.bcc = target.kind == LatticeKind::bcc;
  target.time_step = 0;
  target.last_layer = target.space.cosets() - 1;
  for (size_t a = 0; a < 3; ++a) {
    const double size = extent.high[a] - extent.low[a], distance = spacing[a] * target.space.plane_distance();
    const double planes = std::ceil(size / distance - 1e-9);
    if (!(planes < most_planes))
      fail(Code::limit_exceeded, "slice: more than 1e6 planes along an axis; raise the spacing");
    const int32_t inside = std::max(1, static_cast<int32_t>(planes));
    target.space_step[a] = size > 0 ? size / inside : distance;
    target.space.last[a] = inside + 2 * planes_outside;
    target.dims[a] = static_cast<uint32_t>(target.space.last[a]) + 1; // planes; only 1 or more matters here
  }
  return target;
}

// Returns what the field is at the sites of a slice. sample_begin: the part of the work that is done.
std::vector<BrickLayer> sample_sites(Slice& slice, const ThickField& field, const Lattice4& target,
                                     const Wanted& wanted, double sample_begin, const Context& context) {
  std::vector<BrickLayer> samples;
  const Placement placed(slice);
  const double part = (sample_end - sample_begin) / target.space.cosets();
  for (int c = 0; c < target.space.cosets(); ++c) {
    Progress sampling(context.progress, sample_begin + c * part, sample_begin + (c + 1) * part);
    samples.push_back(sample_coset(field, slice, target, c, placed, wanted, context.with(sampling)));
  }
  return samples;
}

// Makes the coefficients of a slice of its samples.
void filter_samples(Slice& slice, const Lattice4& target, std::vector<BrickLayer> samples, float prune,
                    const Context& context) {
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(samples));
  const MemorySamples memory(target, {slice.base}, std::move(channels));
  const Coefficients filtered(memory, 0, slice.kernel, prune, std::numeric_limits<uint64_t>::max());
  Progress filtering(context.progress, sample_end, 1);
  for (int c = 0; c < target.space.cosets(); ++c)
    slice.coset[c] = *filtered.layer(c, context.with(filtering));
}

// Evaluates the volume's field point by point at a slice of even positions.
void fill_evenly(Slice& slice, const Coefficients& coefficients, const HypersliceOptions& options,
                 const Lattice4& target, const Context& context) {
  if (options.thickness.length > 0)
    fail(Code::unsupported,
         "slice: axes are unevenly spaced: in even positions an oblique slice has no thickness");
  const ThickField field(coefficients, slice.hyperplane, {});
  slice.base = field.base(), slice.air = field.air();
  const Lattice4& lattice = coefficients.source().lattice();
  const PlaneAxes axes{slice.origin, slice.basis};
  const Vec3 spacing = plane_spacings(lattice, options, axes);
  const double margin = slice_margin(slice, *std::max_element(spacing.begin(), spacing.end()));
  const Wanted wanted{lattice, nullptr, margin, {}, options.even.get()};
  for (const Vec4& b : slice.basis)
    slice.lacking = std::max(slice.lacking, plane_refinement(*options.even, b) / most_refined);
  filter_samples(slice, target, sample_sites(slice, field, target, wanted, 0, context), coefficients.prune(),
                 context);
}

// Sets base and air of a slice to those of the volume's field and returns its samples.
std::vector<BrickLayer> plane_samples(Slice& slice, const Coefficients& coefficients,
                                      const HypersliceOptions& options, const Lattice4& target,
                                      const PlaneExtent& extent, const Context& context);

} // namespace

Slice bare_plane(const Coefficients& coefficients, const Hyperplane& h, const HypersliceOptions& options,
                 const Affine3& index_to_world) {
  const Lattice4& lattice = coefficients.source().lattice();
  if (lattice.is_static()) fail(Code::unsupported, "a static volume has no hyperplanes but its time slice");
  if (!(options.spacing >= 0 && std::isfinite(options.spacing) && options.time_length > 0 &&
        std::isfinite(options.time_length)))
    fail(Code::invalid_argument, "slice: the spacing must not be negative, the time length positive");
  if (options.target == LatticeKind::d4star)
    fail(Code::invalid_argument, "slice: the target lattice is BCC or CC");

  Slice slice;
  const bool bcc = options.target.value_or(LatticeKind::bcc) == LatticeKind::bcc;
  slice.kernel = coefficients.kernel();
  if (bcc != lattice.space.bcc) // the same kernel's form for the other lattice
    slice.kernel = bcc ? make_kernel(slice.kernel.name) : make_cc_kernel(slice.kernel.name).kernel;
  slice.hyperplane = h;
  const PlaneAxes axes = options.axes.value_or(plane_axes(h));
  slice.origin = axes.origin, slice.basis = axes.basis;
  slice.slice_to_world = world_affine(axes, index_to_world, options.time_length);
  const PlaneExtent extent = plane_extent(lattice, h, axes);
  const Lattice4 target = target_lattice(lattice, options, axes, extent);
  slice.lattice = target.space;
  const Vec3 unit = target.lattice_unit();
  for (size_t a = 0; a < 3; ++a) {
    slice.lattice_to_slice.linear[a] = {};
    slice.lattice_to_slice.linear[a][a] = unit[a];
    slice.domain_begin[a] = extent.empty ? 0 : planes_outside * slice.lattice.plane_distance();
    slice.domain_end[a] =
        extent.empty ? -1 : slice.domain_begin[a] + (extent.high[a] - extent.low[a]) / unit[a];
    slice.lattice_to_slice.offset[a] = extent.low[a] - unit[a] * slice.domain_begin[a];
  }
  for (int c = 0; c < slice.lattice.cosets(); ++c) slice.coset[c] = BrickLayer(slice.lattice, c);
  slice.base = coefficients.base(), slice.air = coefficients.air();
  slice.bounds = {slice.base, slice.base};
  if (!extent.empty) slice.clip = domain_faces(lattice, slice, Placement(slice));
  return slice;
}

Slice plane_slice(const Coefficients& coefficients, const Hyperplane& h, const HypersliceOptions& options,
                  const Affine3& index_to_world, const Context& context) {
  const auto start = std::chrono::steady_clock::now();
  const Lattice4& lattice = coefficients.source().lattice();
  Slice slice = bare_plane(coefficients, h, options, index_to_world);
  if (slice.empty()) return slice;
  const PlaneAxes axes{slice.origin, slice.basis};
  const PlaneExtent extent = plane_extent(lattice, h, axes);
  const Lattice4 target = target_lattice(lattice, options, axes, extent);
  if (options.even) {
    fill_evenly(slice, coefficients, options, target, context);
  } else if (coarser_plane(lattice, options, axes)) {
    HypersliceOptions own = options;
    own.spacing = 0;
    Slice fine = bare_plane(coefficients, h, own, index_to_world);
    auto samples =
        plane_samples(fine, coefficients, own, target_lattice(lattice, own, axes, extent), extent, context);
    for (size_t c = 0; c < samples.size(); ++c) fine.coset[c] = std::move(samples[c]);
    const Reservation held(context.memory, fine.bytes(), "slice: samples to be low-passed");
    filter_samples(slice, target, lowpassed_plane(slice, fine, lattice, options, context),
                   coefficients.prune(), context);
  } else {
    filter_samples(slice, target, plane_samples(slice, coefficients, options, target, extent, context),
                   coefficients.prune(), context);
  }
  slice.bounds = coefficient_bounds(slice);
  slice.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return slice;
}

namespace {

std::vector<BrickLayer> plane_samples(Slice& slice, const Coefficients& coefficients,
                                      const HypersliceOptions& options, const Lattice4& target,
                                      const PlaneExtent& extent, const Context& context) {
  const Lattice4& lattice = coefficients.source().lattice();
  const Hyperplane& h = slice.hyperplane;
  const auto [margin, reach, region] = reads_of(coefficients, slice, extent, options);
  const TouchedSamples touched(coefficients.source(), h, reach, region);
  const int channel = coefficients.channel();
  Progress reading(context.progress, 0, read_end);
  const auto held = HeldSamples::read(touched, channel, region, coefficients.cache_bytes() / held_part,
                                      context.with(reading));
  const SampleSource& source = held ? static_cast<const SampleSource&>(*held) : touched;
  const Coefficients local(source, channel, coefficients.kernel(), coefficients.prune(),
                           coefficients.cache_bytes(), region);
  const ThickField field(local, h, options.thickness, options.bandwidth);
  slice.base = field.base(), slice.air = field.air();
  Wanted wanted{lattice, nullptr, margin, value_reach(coefficients, options), nullptr};
  for (size_t i = 0; i < 4; ++i) wanted.reach[i] += reach.half_thickness * std::fabs(h[i]);
  // The sum over a line that the domain cuts short lacks some of the base, which is not nothing.
  std::optional<Occupancy> occupancy;
  if (held && (options.thickness.kind != ThicknessKind::sum || coefficients.base() == 0)) {
    occupancy.emplace(lattice);
    const double beyond = margin + wanted.reach[3], part = (make_end - read_end) / lattice.layers();
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const double at = lattice.layer_frame(m), low = extent.box_low[3] - beyond,
                   high = extent.box_high[3] + beyond;
      const bool turned =
          lattice.periodic && (at + lattice.last_frame() <= high || at - lattice.last_frame() >= low);
      Progress making(context.progress, read_end + m * part, read_end + (m + 1) * part);
      if (turned || (at >= low && at <= high)) occupancy->add(m, *local.layer(m, context.with(making)));
    }
    wanted.occupancy = &*occupancy;
  }
  return sample_sites(slice, field, target, wanted, occupancy ? make_end : read_end, context);
}

} // namespace

void list_plane_reads(const Coefficients& coefficients, const Hyperplane& h, const HypersliceOptions& options,
                      LayerReads& out) {
  const Slice slice = bare_plane(coefficients, h, options, {});
  if (slice.empty()) return;
  const SampleSource& source = coefficients.source();
  const std::vector<int32_t> layers = all_layers(source.lattice());
  if (options.even) return source.list_reads(layers, {}, out);
  const PlaneReads reads =
      reads_of(coefficients, slice, plane_extent(source.lattice(), h, {slice.origin, slice.basis}), options);
  TouchedSamples(source, h, reads.reach, reads.region).list_reads(layers, {}, out);
}

} // namespace bccsplat
