// SPDX-License-Identifier: Apache-2.0
// Sums the coefficients around every site of a layer, brick by brick, with weights that are the same for all
// sites: those of the kernel at the distances between sites.
#include "field/coefficients/sampled_field.h"

#include <algorithm>
#include <cmath>
#include <map>

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

// The values of a brick of a layer and of `margin` sites around it, mirrored at the ends of the lattice.
class Surroundings {
 public:
  static constexpr int most_margin = 3;

  // Returns false where there is nothing but air.
  bool fill(const BrickLayer& layer, const Int3& first, const Int3& size, int margin) {
    margin_ = margin;
    bool any = false;
    for (size_t a = 0; a < 3; ++a)
      for (int i = -margin; i < size[a] + margin; ++i)
        at_[a][static_cast<size_t>(i + margin)] = layer.lattice().mirror(a, layer.coset(), first[a] + i);
    for (int z = 0; z < size[2] + 2 * margin; ++z)
      for (int y = 0; y < size[1] + 2 * margin; ++y) any |= fill_row(layer, y, z, size[0] + 2 * margin);
    return any;
  }
  // The value at site (-margin, y, z) of the brick.
  [[nodiscard]] const float* row(int y, int z) const {
    return values_.data() + ((z + margin_) * width + y + margin_) * width;
  }
  [[nodiscard]] int margin() const { return margin_; }

 private:
  static constexpr int width = brick_edge + 2 * most_margin;

  bool fill_row(const BrickLayer& layer, int y, int z, int count) {
    float* const to = values_.data() + (z * width + y) * width;
    const int sy = at_[1][static_cast<size_t>(y)], sz = at_[2][static_cast<size_t>(z)];
    const size_t row = static_cast<size_t>(sz % brick_edge * brick_edge + sy % brick_edge) * brick_edge;
    bool any = false;
    const Brick* brick = nullptr;
    int held = -1;
    for (int x = 0; x < count; ++x) {
      const int sx = at_[0][static_cast<size_t>(x)];
      if (sx / brick_edge != held) {
        held = sx / brick_edge;
        brick = layer.brick(held, sy / brick_edge, sz / brick_edge);
        any |= brick != nullptr;
      }
      to[x] = brick ? brick->value[row + static_cast<size_t>(sx % brick_edge)] : 0.0f;
    }
    return any;
  }

  int margin_ = 0;
  std::array<std::array<int32_t, width>, 3> at_{};
  std::array<float, static_cast<size_t>(width) * width * width> values_{};
};

struct Neighbour {
  const BrickLayer* layer;
  std::vector<Tap> taps;
};

// Adds what the coefficients of one layer give to the sites of a brick; returns whether there are any.
bool add_layer(const Neighbour& from, int coset, const Int3& first, const Int3& size, Surroundings& around,
               Brick& sums) {
  const bool bcc = from.layer->lattice().bcc;
  // Planes between sites of the two cosets are odd: site i of coset c lies on plane 2 i + c.
  const int shift = bcc ? coset - from.layer->coset() : 0;
  const auto sites = [&](int planes) { return bcc ? (planes + shift) / 2 : planes; };
  int margin = 0;
  for (const Tap& t : from.taps)
    for (const int32_t p : t.planes) margin = std::max(margin, std::abs(sites(p)));
  if (!around.fill(*from.layer, first, size, margin)) return false;
  for (const Tap& t : from.taps)
    for (int z = 0; z < size[2]; ++z)
      for (int y = 0; y < size[1]; ++y) {
        const float* in =
            around.row(y + sites(t.planes[1]), z + sites(t.planes[2])) + margin + sites(t.planes[0]);
        float* out = sums.value.data() + (z * brick_edge + y) * brick_edge;
        for (int x = 0; x < size[0]; ++x) out[x] += t.weight * in[x];
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

} // namespace

SampledField::SampledField(const SampleSource& stored, const Kernel& kernel, float prune)
    : stored_(stored), taps_(taps_of(stored.lattice(), kernel)), prune_(prune) {}

BrickLayer SampledField::read_layer(int channel, int32_t layer, const BrickBox& region,
                                    const Context& context) const {
  const Lattice4& lattice = stored_.lattice();
  const BrickBox wider = region.widened(); // the kernel reaches less than a brick
  std::map<int32_t, BrickLayer> read;
  std::vector<Neighbour> neighbours;
  for (const Tap& t : taps_) {
    const int32_t m = lattice.mirror_layer(layer + t.layer);
    if (!read.contains(m)) read[m] = stored_.read_layer(channel, m, wider, context);
    if (neighbours.empty() || neighbours.back().taps.front().layer != t.layer)
      neighbours.push_back({&read[m], {}});
    neighbours.back().taps.push_back(t);
  }
  const BrickLayer& own = read.at(layer);
  BrickLayer out(lattice.space, own.coset());
  context.tasks.parallel_for(out.brick_slots(), [&](uint64_t slot) {
    context.progress.check();
    const Int3 position = out.slot_position(slot);
    if (!region.contains(position)) return;
    Int3 first, size;
    for (size_t a = 0; a < 3; ++a) {
      first[a] = position[a] * brick_edge;
      size[a] = std::min(brick_edge, out.dims()[a] - first[a]);
    }
    auto sums = std::make_shared<Brick>();
    const auto around = std::make_unique<Surroundings>();
    bool any = false;
    for (const Neighbour& n : neighbours) any |= add_layer(n, own.coset(), first, size, *around, *sums);
    if (any && finish(*sums, own.brick(slot), prune_)) out.set(slot, std::move(sums));
  });
  return out;
}

} // namespace bccsplat
