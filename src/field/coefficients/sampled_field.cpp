// SPDX-License-Identifier: Apache-2.0
// Sums the coefficients around every site of a layer, brick by brick, with weights that are the same for all
// sites: those of the kernel at the distances between sites.
#include "field/coefficients/sampled_field.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "kernel/kernel_time.h"

namespace bccsplat {
namespace {

using Tap = SampledField::Tap;

// Calls body(planes) for all differences between a site and those of a coset of this parity, within `reach`
// planes along each axis.
template<class Body> void for_neighbours(bool bcc, int parity, int reach, Body&& body) {
  const int pitch = bcc ? 2 : 1, lowest = bcc && ((reach ^ parity) & 1) ? -reach + 1 : -reach;
  for (int z = lowest; z <= reach; z += pitch)
    for (int y = lowest; y <= reach; y += pitch)
      for (int x = lowest; x <= reach; x += pitch) body(Int3{x, y, z});
}

std::vector<Tap> taps_of(const Lattice4& lattice, const Kernel& kernel) {
  const double distance = lattice.space.plane_distance();
  const int reach = static_cast<int>(std::ceil(kernel.space.radius / distance));
  const bool still = lattice.is_static();
  const int cosets = lattice.space.cosets() - 1;
  const int layers =
      still ? cosets : static_cast<int>(std::ceil(time_reach(kernel) / kernel_time_per_layer(lattice)));
  std::vector<Tap> taps;
  for (int d = still ? 0 : -layers; d <= layers; ++d) {
    const double in_time = still ? 1 : kernel.time.value(d * kernel_time_per_layer(lattice));
    for_neighbours(lattice.space.bcc, d & 1, reach, [&](const Int3& planes) {
      double r2 = 0;
      for (const int32_t p : planes) r2 += p * p * distance * distance;
      const double weight = in_time * kernel.space.value(r2);
      if (weight != 0) taps.push_back({d, planes, static_cast<float>(weight)});
    });
  }
  return taps;
}

// Sites of a brick: `size` of them along each axis from `first` on, which is counted within the brick.
struct BrickPart {
  Int3 brick, first, size; // position, in bricks; sites
};

// The part of a brick that lies on these planes; empty where a size is not above 0.
BrickPart part_on(const BrickLayer& layer, const Int3& brick, const PlaneRange& planes) {
  BrickPart part{brick, {}, {}};
  for (size_t a = 0; a < 3; ++a) part.size[a] = std::min(brick_edge, layer.dims()[a] - brick[a] * brick_edge);
  const size_t axis = planes.axis;
  const int first_site = brick[axis] * brick_edge, pitch = layer.lattice().cosets();
  // Sites whose planes are in the range: the first one rounded up, the last one down.
  const auto before = [&](int32_t plane) { // sites of the coset before a plane, at least 0
    return std::max(0, plane - layer.coset() + pitch - 1) / pitch;
  };
  const int begin = std::max(first_site, before(planes.first));
  int end = first_site + part.size[axis];
  if (planes.last < layer.lattice().last[axis]) end = std::min(end, before(planes.last + 1));
  part.first[axis] = begin - first_site, part.size[axis] = end - begin;
  return part;
}

// The values of a part of a brick and of `margin` sites around it, mirrored at the ends of the lattice.
class Surroundings {
 public:
  static constexpr int most_margin = 3;

  // Returns false where there is nothing but air.
  bool fill(const BrickLayer& layer, const BrickPart& part, int margin) {
    margin_ = margin;
    bool any = false;
    const Int3& size = part.size;
    for (size_t a = 0; a < 3; ++a)
      for (int i = -margin; i < size[a] + margin; ++i)
        at_[a][i + margin] =
            layer.lattice().mirror(a, layer.coset(), part.brick[a] * brick_edge + part.first[a] + i);
    find_runs(size[0] + 2 * margin);
    for (int z = 0; z < size[2] + 2 * margin; ++z)
      for (int y = 0; y < size[1] + 2 * margin; ++y) any |= fill_row(layer, y, z);
    return any;
  }
  // The value at site (-margin, y, z) of the part.
  [[nodiscard]] const float* row(int y, int z) const {
    return values_.data() + ((z + margin_) * width + y + margin_) * width;
  }
  [[nodiscard]] int margin() const { return margin_; }

 private:
  static constexpr int width = brick_edge + 2 * most_margin;

  // Sites of a row that follow each other in one brick, too.
  struct Run {
    int brick, first, to, count; // first: within the brick
  };
  void find_runs(int count) {
    runs_.clear();
    for (int x = 0; x < count; ++x) {
      const int site = at_[0][x], brick = site / brick_edge, within = site % brick_edge;
      if (!runs_.empty() && runs_.back().brick == brick && runs_.back().first + runs_.back().count == within)
        ++runs_.back().count;
      else
        runs_.push_back({brick, within, x, 1});
    }
  }
  bool fill_row(const BrickLayer& layer, int y, int z) {
    float* const row = values_.data() + (z * width + y) * width;
    const int sy = at_[1][y], sz = at_[2][z];
    const int at = (sz % brick_edge * brick_edge + sy % brick_edge) * brick_edge;
    bool any = false;
    for (const Run& run : runs_) {
      const Brick* const brick = layer.brick(run.brick, sy / brick_edge, sz / brick_edge);
      any |= brick != nullptr;
      if (brick)
        std::copy_n(brick->value.data() + at + run.first, run.count, row + run.to);
      else
        std::fill_n(row + run.to, run.count, 0.0f);
    }
    return any;
  }

  int margin_ = 0;
  std::array<std::array<int32_t, width>, 3> at_{};
  std::vector<Run> runs_;
  std::array<float, static_cast<size_t>(width) * width * width> values_{};
};

struct Neighbour {
  const BrickLayer* layer;
  std::vector<Tap> taps;
};

// A tap within Surroundings: how far its value is from that of the site.
struct PlacedTap {
  std::ptrdiff_t at;
  float weight;
};

// Adds to `size` sites of a row what the taps give, in their order. `width`, at least `size`: sites that are
// summed, so that sums stay in registers from tap to tap.
template<int width> void add_row(const float* in, std::span<const PlacedTap> taps, float* out, int size) {
  std::array<float, width> sums{};
  if (size == width) // a copy of known size is no call
    std::copy_n(out, width, sums.begin());
  else
    std::copy_n(out, size, sums.begin());
  for (const PlacedTap& t : taps) {
    const float* const from = in + t.at;
    for (int x = 0; x < width; ++x) sums[x] += t.weight * from[x];
  }
  if (size == width)
    std::copy_n(sums.begin(), width, out);
  else
    std::copy_n(sums.begin(), size, out);
}

// Adds what the coefficients of one layer give to the sites of a part of a brick; returns whether there are
// any.
bool add_layer(const Neighbour& from, int coset, const BrickPart& part, Surroundings& around, Brick& sums) {
  const bool bcc = from.layer->lattice().bcc;
  // Planes between sites of the two cosets are odd: site i of coset c lies on plane 2 i + c.
  const int shift = bcc ? coset - from.layer->coset() : 0;
  const auto sites = [&](int planes) { return bcc ? (planes + shift) / 2 : planes; };
  int margin = 0;
  for (const Tap& t : from.taps)
    for (const int32_t p : t.planes) margin = std::max(margin, std::abs(sites(p)));
  if (!around.fill(*from.layer, part, margin)) return false;
  std::vector<PlacedTap> taps;
  taps.reserve(from.taps.size());
  const float* const origin = around.row(0, 0) + margin;
  for (const Tap& t : from.taps)
    taps.push_back({around.row(sites(t.planes[1]), sites(t.planes[2])) + margin + sites(t.planes[0]) - origin,
                    t.weight});
  const auto& [at_x, at_y, at_z] = part.first;
  constexpr int half = brick_edge / 2;
  for (int z = 0; z < part.size[2]; ++z)
    for (int y = 0; y < part.size[1]; ++y) {
      const float* const in = around.row(y, z) + margin;
      float* const out = sums.value.data() + ((z + at_z) * brick_edge + y + at_y) * brick_edge + at_x;
      if (part.size[0] <= half)
        add_row<half>(in, taps, out, part.size[0]);
      else
        add_row<brick_edge>(in, taps, out, part.size[0]);
    }
  return true;
}

// Keeps what is above `prune`, and the holes of the stored brick.
bool finish(Brick& brick, const Brick* stored, float prune) {
  int kept = brick.keep_above(prune);
  if (stored && stored->hole) {
    brick.hole = std::make_unique<BrickMask>(*stored->hole);
    for (size_t r = 0; r < brick.kept.size(); ++r)
      brick.kept[r] = static_cast<uint16_t>(brick.kept[r] | (*brick.hole)[r]);
    ++kept;
  }
  return kept > 0;
}

bool goes_beyond(const Lattice3& space, const PlaneRange& planes) {
  return planes.first < 0 || planes.last > space.last[planes.axis];
}

// The order in which stored layers are read for the layers of samples that are asked for, and when they have
// done their part.
class ReadOrder {
 public:
  ReadOrder(const Lattice4& lattice, const std::vector<Tap>& taps, std::span<const int32_t> layers) {
    std::map<int32_t, size_t> position;
    for (size_t i = 0; i < layers.size(); ++i) {
      std::set<int32_t> needed;
      for (const Tap& t : taps) needed.insert(lattice.mirror_layer(layers[i] + t.layer));
      for (const int32_t m : needed) {
        if (position.try_emplace(m, stored_.size()).second) stored_.push_back(m);
        last_use_[m] = i;
      }
      size_t due = 0;
      for (const int32_t m : needed) due = std::max(due, position.at(m));
      needed_.push_back(std::move(needed)), due_.push_back(due);
    }
  }
  [[nodiscard]] std::span<const int32_t> stored() const { return stored_; }
  // Returns whether number i of the layers asked for needs nothing beyond this position among the stored.
  [[nodiscard]] bool due(size_t i, size_t position) const { return i < due_.size() && due_[i] <= position; }
  [[nodiscard]] bool complete(size_t i, const std::map<int32_t, BrickLayer>& read) const {
    return std::ranges::all_of(needed_[i], [&](int32_t m) { return read.contains(m); });
  }
  // Drops what no layer behind number i needs.
  void drop_done(size_t i, std::map<int32_t, BrickLayer>& read) const {
    std::erase_if(read, [&](const auto& held) { return last_use_.at(held.first) <= i; });
  }

 private:
  std::vector<int32_t> stored_;
  std::map<int32_t, size_t> last_use_;
  std::vector<std::set<int32_t>> needed_; // by layers asked for
  std::vector<size_t> due_;               // likewise: the last position of those
};

} // namespace

SampledField::SampledField(const SampleSource& stored, const Kernel& kernel, float prune)
    : stored_(stored), taps_(taps_of(stored.lattice(), kernel)), prune_(prune) {}

void SampledField::read(int channel, std::span<const int32_t> layers, const Wanted& wanted,
                        const BrickBox& stored, const Context& context,
                        const TakeLayer<BrickLayer>& take) const {
  const ReadOrder order(lattice(), taps_, layers);
  std::map<int32_t, BrickLayer> read;
  size_t position = 0, made = 0;
  stored_.read_layers(channel, order.stored(), stored, context, [&](int32_t m, BrickLayer&& layer) {
    while (order.stored()[position] != m) ++position; // what has to wait is left out
    read[m] = std::move(layer);
    for (; order.due(made, position); ++made) {
      if (order.complete(made, read)) take(layers[made], make(layers[made], wanted, read, context));
      order.drop_done(made, read);
    }
  });
}

void SampledField::read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                               const Context& context, const TakeLayer<BrickLayer>& take) const {
  // The kernel reaches less than a brick.
  read(channel, layers, {region, {}}, region.widened(), context, take);
}

void SampledField::read_samples(int channel, std::span<const int32_t> layers, const BrickBox& region,
                                const Context& context, const TakeLayer<SampleLayer>& take) const {
  read_layers(channel, layers, region, context,
              [&](int32_t m, BrickLayer&& layer) { take(m, SampleLayer(layer)); });
}

BrickBox SampledField::stored_around(const PlaneRange& planes) const {
  const Lattice3& space = lattice().space;
  int32_t reach = 0;
  for (const Tap& t : taps_) reach = std::max(reach, std::abs(t.planes[planes.axis]));
  PlaneRange wider = planes;
  const int32_t last = space.last[planes.axis];
  if (!goes_beyond(space, planes)) // mirror images lie no further from an end than what they are images of
    wider.first = std::max(0, planes.first - reach), wider.last = std::min(last, planes.last + reach);
  return go_round(bricks_on(space, wider), space);
}

void SampledField::read_planes(int channel, std::span<const int32_t> layers, const PlaneRange& planes,
                               const Context& context, const TakeLayer<BrickLayer>& take) const {
  const Lattice3& space = lattice().space;
  read(channel, layers, {bricks_on(space, planes), goes_beyond(space, planes) ? PlaneRange{} : planes},
       stored_around(planes), context, take);
}

void SampledField::list_reads(std::span<const int32_t> layers, const BrickBox& region,
                              LayerReads& out) const {
  stored_.list_reads(ReadOrder(lattice(), taps_, layers).stored(), region.widened(), out);
}

void SampledField::list_planes(std::span<const int32_t> layers, const PlaneRange& planes,
                               LayerReads& out) const {
  stored_.list_reads(ReadOrder(lattice(), taps_, layers).stored(), stored_around(planes), out);
}

BrickLayer SampledField::read_layer(int channel, int32_t layer, const BrickBox& region,
                                    const Context& context) const {
  BrickLayer out;
  read_layers(channel, std::span(&layer, 1), region, context,
              [&](int32_t, BrickLayer&& made) { out = std::move(made); });
  return out;
}

// `stored`: at least the layers that this one depends on.
BrickLayer SampledField::make(int32_t layer, const Wanted& wanted,
                              const std::map<int32_t, BrickLayer>& stored, const Context& context) const {
  const Lattice4& lattice = stored_.lattice();
  std::vector<Neighbour> neighbours;
  for (const Tap& t : taps_) {
    if (neighbours.empty() || neighbours.back().taps.front().layer != t.layer)
      neighbours.push_back({&stored.at(lattice.mirror_layer(layer + t.layer)), {}});
    neighbours.back().taps.push_back(t);
  }
  const BrickLayer& own = stored.at(layer);
  BrickLayer out(lattice.space, own.coset());
  context.tasks.parallel_for(out.brick_slots(), [&](uint64_t slot) {
    context.progress.check();
    const Int3 position = out.slot_position(slot);
    if (!wanted.region.contains(position)) return;
    const BrickPart part = part_on(out, position, wanted.planes);
    if (part.size[wanted.planes.axis] <= 0) return;
    auto sums = std::make_shared<Brick>();
    const auto around = std::make_unique<Surroundings>();
    bool any = false;
    for (const Neighbour& n : neighbours) any |= add_layer(n, own.coset(), part, *around, *sums);
    if (any && finish(*sums, own.brick(slot), prune_)) out.set(slot, std::move(sums));
  });
  return out;
}

} // namespace bccsplat
