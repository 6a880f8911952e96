// SPDX-License-Identifier: Apache-2.0
// Finds the 4D lattice points near a hyperplane and sorts them into cells of slice space: layer by layer, the
// bricks of a layer by all threads. They are counted first, so that their memory is reserved before it grows.
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "slice/extraction.h"
#include "slice/extraction_gaussian.h"
#include "slice/layer_weights.h"
#include "slice/touched_samples.h"

namespace bccsplat {
namespace {

// Where a plane of sites and its mirror images beyond the ends of the lattice stand along an axis, in lattice
// units from source sample 0.
using Places = std::vector<double>;

// Returns the plane inside that stands for one beyond the ends.
size_t folded(int32_t plane, int32_t last) {
  const int32_t period = 2 * last, turned = (plane % period + period) % period;
  return static_cast<size_t>(std::min(turned, period - turned));
}

// Returns them by plane; images that no point of the domain sees are left out.
std::vector<Places> places_along(const Lattice4& lattice, size_t axis) {
  const double d = lattice.space.plane_distance(), reach = paper_reach / d;
  const int32_t last = lattice.space.last[axis], before = lattice.before[axis];
  const int32_t begin = std::min(0, static_cast<int32_t>(std::floor(before - reach)) + 1);
  const int32_t end =
      std::max(last, static_cast<int32_t>(std::ceil(before + lattice.inner_planes(axis) + reach)) - 1);
  std::vector<Places> places(lattice.space.planes(axis));
  for (int32_t plane = begin; plane <= end; ++plane)
    places[folded(plane, last)].push_back(d * (plane - before));
  return places;
}

// The sites of one layer that are kept and their mirror images, in lattice units from source sample 0, which
// are handed to body(position, value) brick by brick.
struct LayerSites {
  const std::array<std::vector<Places>, 3>& places;
  const BrickLayer& layer;
  double time; // of the layer

  template<class Body> void each(size_t slot, const Body& body) const {
    const Brick* brick = layer.brick(slot);
    if (!brick) return;
    const Int3 b = layer.slot_position(slot);
    const auto of = [&](size_t a, int site) -> const Places& {
      return places[a][layer.lattice().plane(layer.coset(), b[a] * brick_edge + site)];
    };
    for (int s = 0; s < brick_sites; ++s) {
      if (!(brick->kept[s / brick_edge] >> s % brick_edge & 1)) continue;
      const Places &x = of(0, s % brick_edge), &y = of(1, s / brick_edge % brick_edge),
                   &z = of(2, s / brick_rows);
      for (const double at_z : z)
        for (const double at_y : y)
          for (const double at_x : x) body(Vec4{at_x, at_y, at_z, time}, brick->value[s]);
    }
  }
};

void check_source(const SampleSource& source) {
  if (source.lattice().is_static())
    fail(Code::unsupported, "slice: extracted points are of series only; choose another method");
  if (source.lattice().space.any_periodic())
    fail(Code::unsupported, "slice: extracted points: an axis of space is periodic; choose another method");
}

// Returns index units -> lattice units.
Vec4 scales_of(const Lattice4& lattice) {
  const Vec3 unit = lattice.lattice_unit();
  return {1 / unit[0], 1 / unit[1], 1 / unit[2], lattice.layer_distance() / lattice.time_step};
}

TouchedSamples touched_by(const SampleSource& source, const Hyperplane& h) {
  const Vec4 scale = scales_of(source.lattice());
  TouchReach touch;
  for (size_t a = 0; a < 4; ++a) touch.samples[a] = paper_reach / scale[a];
  return {source, h, touch};
}

} // namespace

void Extraction::list_reads(const SampleSource& source, const Hyperplane& h, LayerReads& out) {
  check_source(source);
  touched_by(source, h).list_reads(all_layers(source.lattice()), {}, out);
}

Extraction::Extraction(const SampleSource& source, int channel, const Hyperplane& h, const PlaneAxes& axes,
                       const Affine3& lattice_to_slice, const Context& context)
    : axes_(axes), bcc_(source.lattice().space.bcc), air_(source.air(channel)), base_(source.base(channel)) {
  check_source(source);
  set_axes(source.lattice(), lattice_to_slice);
  SharedReservation finding(context.memory);
  sort_into_cells(collect(source, channel, h, finding, context), context);
}

// Brings slice space to lattice units, in which the Gaussian is round.
void Extraction::set_axes(const Lattice4& lattice, const Affine3& lattice_to_slice) {
  scale_ = scales_of(lattice);
  for (size_t a = 0; a < 4; ++a) {
    end_[a] = lattice.domain_end(a);
    origin_[a] = axes_.origin[a] * scale_[a];
  }
  std::array<Vec4, 3> directions = axes_.basis;
  for (Vec4& d : directions)
    for (size_t a = 0; a < 4; ++a) d[a] *= scale_[a];
  directions_ = plane_axes(origin_, directions).basis;
  for (size_t k = 0; k < 3; ++k)
    for (size_t j = 0; j < 3; ++j) along_.linear[k][j] = dot4(directions[j], directions_[k]);
  of_lattice_ = along_.after(lattice_to_slice);
}

Extraction::Found Extraction::collect(const SampleSource& source, int channel, const Hyperplane& h,
                                      SharedReservation& memory, const Context& context) {
  const Lattice4& lattice = source.lattice();
  const Hyperplane plane(h[0] / scale_[0], h[1] / scale_[1], h[2] / scale_[2], h[3] / scale_[3], h[4]);
  const TouchedSamples touched = touched_by(source, h);
  // Layers beyond the ends are mirror images, of a periodic series those at its other end.
  const double reach = paper_reach / lattice.layer_distance(), end = lattice.last_frame() / lattice.time_step;
  const int32_t first_layer = std::min(0, static_cast<int32_t>(std::floor(lattice.lead - reach)) + 1);
  const int32_t last_layer =
      std::max(lattice.last_layer, static_cast<int32_t>(std::ceil(lattice.lead + end + reach)) - 1);
  const std::array<std::vector<Places>, 3> places{places_along(lattice, 0), places_along(lattice, 1),
                                                  places_along(lattice, 2)};
  Found found;
  for (int32_t m = first_layer; m <= last_layer; ++m) {
    context.progress.advance(m - first_layer, last_layer + 1 - first_layer);
    const BrickLayer layer = touched.read_layer(channel, lattice.mirror_layer(m), {}, context);
    const LayerSites sites{places, layer, (m - lattice.lead) * lattice.layer_distance()};
    std::vector<uint64_t> first(layer.brick_slots() + 1); // of each brick's points
    context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
      sites.each(slot, [&](const Vec4& p, float) {
        first[slot + 1] += std::fabs(height(plane, p)) < paper_reach ? 1 : 0;
      });
    });
    for (size_t slot = 1; slot < first.size(); ++slot) first[slot] += first[slot - 1];
    memory.add(first.back() * sizeof(Point), "slice: finding extracted points");
    std::vector<Point> points(first.back());
    context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
      Point* next = points.data() + first[slot];
      sites.each(slot, [&](Vec4 p, float value) {
        const double distance = height(plane, p);
        if (!(std::fabs(distance) < paper_reach)) return;
        for (size_t a = 0; a < 4; ++a) p[a] -= origin_[a];
        Point& point = *next++;
        for (size_t k = 0; k < 3; ++k) point.at[k] = static_cast<float>(dot4(p, directions_[k]));
        point.weighted = static_cast<float>(std::exp(-paper_gaussian * distance * distance)) * value;
        point.d2 = static_cast<float>(distance * distance);
      });
    });
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot)
      if (const Brick* const brick = layer.brick(slot); brick && first[slot + 1] > first[slot])
        for (const float v : brick->value) range_ = {std::min(range_[0], v), std::max(range_[1], v)};
    found.push_back(std::move(points));
  }
  return found;
}

size_t Extraction::cell(const std::array<float, 3>& at) const {
  size_t index = 0;
  for (size_t k = 3; k-- > 0;)
    index = index * cells_[k] + static_cast<size_t>((at[k] - low_[k]) / extraction_cell);
  return index;
}

void Extraction::sort_into_cells(const Found& found, const Context& context) {
  uint64_t count = 0;
  std::array<float, 3> high{};
  for (const std::vector<Point>& layer : found) {
    if (count == 0 && !layer.empty()) low_ = high = layer[0].at;
    count += layer.size();
    for (const Point& p : layer)
      for (size_t k = 0; k < 3; ++k)
        low_[k] = std::min(low_[k], p.at[k]), high[k] = std::max(high[k], p.at[k]);
  }
  for (size_t k = 0; k < 3; ++k) cells_[k] = 1 + static_cast<int>((high[k] - low_[k]) / extraction_cell);
  const size_t cells = static_cast<size_t>(cells_[0]) * cells_[1] * cells_[2];
  memory_ = Reservation(context.memory, count * sizeof(Point) + (2 * cells + 1) * sizeof(uint64_t),
                        "slice: extracted points");
  start_.resize(cells + 1);
  for (const std::vector<Point>& layer : found)
    for (const Point& p : layer) ++start_[cell(p.at) + 1];
  for (size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  points_.resize(count);
  std::vector<uint64_t> next(start_.begin(), start_.end() - 1);
  for (const std::vector<Point>& layer : found)
    for (const Point& p : layer) points_[next[cell(p.at)]++] = p;
}

} // namespace bccsplat
