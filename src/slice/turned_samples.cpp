// SPDX-License-Identifier: Apache-2.0
// Reads the planes of a volume that lie across one spatial axis and turns them into layers of the turned
// volume.
#include "slice/turned_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"

namespace bccsplat {
namespace {

// Returns the site of a coset on a plane.
int site_of(const Lattice3& lattice, int coset, int32_t plane) {
  return lattice.bcc ? (plane - coset) / 2 : plane;
}

constexpr int32_t layers_at_once = 1 << 15; // a multiple of the layers of most slabs

uint64_t slots_of(const Lattice3& lattice) {
  uint64_t slots = 1;
  for (const int32_t n : lattice.dims(0)) slots *= (n + brick_edge - 1) / brick_edge;
  return slots;
}

using OpenBricks = std::vector<std::shared_ptr<Brick>>; // by slot of the turned layer

// Copies site `at` along the axis of all bricks of `from`, a plane of 16 x 16 sites each, to the bricks of
// the turned layer, where it becomes the plane `time_site` (the third axis is the volume's time).
void copy_plane(const BrickLayer& from, size_t axis, int at, const BrickLayer& layer, int time_site,
                OpenBricks& to) {
  const std::array<size_t, 4> axes = turned_axes(axis);
  constexpr std::array<int, 3> stride{1, brick_edge, brick_rows};
  const int first = stride[axes[0]], second = stride[axes[1]];
  const Int3& bricks = from.brick_dims();
  Int3 b{};
  b[axis] = at / brick_edge;
  const int plane = at % brick_edge * stride[axis];
  const size_t row0 = static_cast<size_t>(time_site % brick_edge) * brick_edge;
  for (b[axes[1]] = 0; b[axes[1]] < bricks[axes[1]]; ++b[axes[1]])
    for (b[axes[0]] = 0; b[axes[0]] < bricks[axes[0]]; ++b[axes[0]]) {
      const Brick* source = from.brick(b[0], b[1], b[2]);
      if (!source) continue;
      auto& brick = to[layer.slot(b[axes[0]], b[axes[1]], time_site / brick_edge)];
      const auto open = [&]() -> Brick& {
        if (!brick) brick = std::make_shared<Brick>();
        return *brick;
      };
      for (int j = 0; j < brick_edge; ++j) {
        const size_t row = row0 + j;
        unsigned kept = 0, hole = 0;
        for (int i = 0; i < brick_edge; ++i) {
          const int site = plane + j * second + i * first;
          kept |= static_cast<unsigned>(source->kept[site / brick_edge] >> site % brick_edge & 1) << i;
          hole |= static_cast<unsigned>(source->is_hole(site)) << i;
        }
        if (kept) {
          Brick& target = open();
          target.kept[row] = static_cast<uint16_t>(kept);
          for (int i = 0; i < brick_edge; ++i)
            target.value[row * brick_edge + i] = source->value[plane + j * second + i * first];
        }
        if (hole) {
          Brick& target = open();
          if (!target.hole) target.hole = std::make_unique<BrickMask>();
          (*target.hole)[row] = static_cast<uint16_t>(hole);
        }
      }
    }
}

} // namespace

std::array<size_t, 4> turned_axes(size_t axis) {
  std::array<size_t, 4> axes{};
  size_t n = 0;
  for (size_t a = 0; a < 4; ++a)
    if (a != axis) axes[n++] = a;
  axes[3] = axis;
  return axes;
}

Lattice4 turned_lattice(const Lattice4& lattice, size_t axis) {
  if (lattice.is_static() || lattice.dims[axis] < 2)
    fail(Code::unsupported, "slice: of an axis, it needs time and more than one sample along the axis");
  const std::array<size_t, 4> axes = turned_axes(axis);
  Lattice4 turned = lattice;
  for (size_t a = 0; a < 3; ++a) {
    turned.dims[a] = lattice.dims[axes[a]];
    turned.space.last[a] = axes[a] == 3 ? lattice.last_layer : lattice.space.last[axes[a]];
    turned.space_step[a] = axes[a] == 3 ? lattice.time_step : lattice.space_step[axes[a]];
    turned.before[a] = axes[a] == 3 ? lattice.lead : lattice.before[axes[a]];
    turned.behind[a] = axes[a] == 3 ? 0 : lattice.behind[axes[a]];
    turned.space.periodic[a] = lattice.turns(axes[a]);
  }
  turned.periodic = lattice.turns(axis);
  turned.dims[3] = lattice.dims[axis];
  // Layers before the first frame become planes outside the domain, and planes outside along the axis become
  // layers before the first.
  turned.lead = lattice.before[axis];
  turned.last_layer = lattice.space.last[axis];
  turned.time_step = lattice.space_step[axis];
  return turned;
}

TurnedSamples::TurnedSamples(const SampleSource& source, int channel, size_t axis, int32_t first,
                             int32_t last, const Context& context)
    : lattice_(turned_lattice(source.lattice(), axis)), air_(source.air(channel)),
      base_(source.base(channel)) {
  const Lattice4& lattice = source.lattice();
  struct Plane {
    int32_t number;
    OpenBricks bricks;
  };
  // Slots of the layers and of the bricks that are open, before there are any.
  constexpr uint64_t slot_bytes = sizeof(std::shared_ptr<const Brick>) + sizeof(std::shared_ptr<Brick>);
  const uint64_t count = std::min(int64_t{last} - first + 1, int64_t{lattice_.layers()});
  Reservation slots(context.memory, count * slots_of(lattice_.space) * slot_bytes, "planes of an axis slice");
  std::vector<Plane> planes;
  for (int32_t h = first; h <= last; ++h) {
    const int32_t plane = lattice_.mirror_layer(h);
    if (!layers_.emplace(plane, BrickLayer(lattice_.space, lattice_.coset(plane))).second) continue;
    planes.push_back({plane, OpenBricks(layers_.at(plane).brick_slots())});
  }
  const BrickBox bricks = bricks_on(lattice.space, {axis, first, last});
  uint64_t read = 0;
  const auto take = [&](int32_t m, BrickLayer&& layer) {
    context.progress.advance(++read, lattice.layers());
    const int coset = lattice.coset(m), time_site = site_of(lattice.space, coset, m);
    context.tasks.parallel_for(planes.size(), [&](uint64_t p) {
      Plane& plane = planes[p];
      if (lattice.coset(plane.number) != coset) return;
      copy_plane(layer, axis, site_of(lattice.space, coset, plane.number), layers_.at(plane.number),
                 time_site, plane.bricks);
    });
  };
  std::vector<int32_t> some;
  for (int32_t m = 0; m < lattice.layers(); m += static_cast<int32_t>(some.size())) {
    some.resize(std::min(layers_at_once, lattice.layers() - m));
    std::iota(some.begin(), some.end(), m);
    source.read_layers(channel, some, bricks, context, take);
  }
  slots = {};
  uint64_t bytes = 0;
  for (Plane& plane : planes) {
    BrickLayer& layer = layers_.at(plane.number);
    for (size_t s = 0; s < plane.bricks.size(); ++s)
      if (plane.bricks[s]) layer.set(s, std::move(plane.bricks[s]));
    bytes += layer.bytes();
  }
  memory_ = Reservation(context.memory, bytes, "samples of an axis slice");
}

BrickLayer TurnedSamples::read_layer(int, int32_t layer, const BrickBox&, const Context&) const {
  const auto found = layers_.find(layer);
  if (found == layers_.end()) fail(Code::internal, "slice: plane ", layer, " was not read");
  return found->second;
}

} // namespace bccsplat
