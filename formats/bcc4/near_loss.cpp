// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/near_loss.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "kernel/cc_kernel.h"
#include "kernel/kernel_time.h"

namespace bccsplat {
namespace {

// The largest whole number below x.
int32_t below(double x) { return static_cast<int32_t>(std::ceil(x - 1e-9)) - 1; }

// Sites begin .. end - 1 along each axis.
struct SiteBox {
  Int3 begin, end;
};

// The sites of a layer within `planes` planes of a brick of either coset.
SiteBox sites_around(const Int3& brick, int32_t planes, const BrickLayer& layer) {
  const int32_t pitch = layer.lattice().bcc ? 2 : 1, coset = layer.coset();
  SiteBox box;
  for (size_t a = 0; a < 3; ++a) {
    const int32_t first = std::max(0, brick[a] * brick_edge * pitch - planes);
    const int32_t last = (brick[a] + 1) * brick_edge * pitch - 1 + planes;
    box.begin[a] = (first - coset + pitch - 1) / pitch;
    box.end[a] = std::min(layer.dims()[a], (last - coset) / pitch + 1);
  }
  return box;
}

// Adds the sites of a box to the masks of their bricks, by slot.
void add_box(const SiteBox& box, const BrickLayer& layer, std::map<size_t, BrickMask>& masks) {
  for (int32_t z = box.begin[2]; z < box.end[2]; ++z)
    for (int32_t y = box.begin[1]; y < box.end[1]; ++y)
      for (int32_t x = box.begin[0]; x < box.end[0]; ++x) {
        const auto [mask, added] =
            masks.try_emplace(layer.slot(x / brick_edge, y / brick_edge, z / brick_edge));
        auto& row = mask->second[z % brick_edge * brick_edge + y % brick_edge];
        row = static_cast<uint16_t>(row | 1u << (x % brick_edge));
      }
}

std::shared_ptr<const Brick> with_holes(const Brick* brick, const BrickMask& holes) {
  auto out = std::make_shared<Brick>();
  if (brick) out->value = brick->value, out->kept = brick->kept;
  out->hole = std::make_unique<BrickMask>(brick && brick->hole ? *brick->hole : BrickMask{});
  for (size_t row = 0; row < holes.size(); ++row) {
    (*out->hole)[row] = static_cast<uint16_t>((*out->hole)[row] | holes[row]);
    out->kept[row] = static_cast<uint16_t>(out->kept[row] | holes[row]);
  }
  return out;
}

} // namespace

// The site nearest to a point is at most one plane from it along any axis (half of one on CC), and at most
// one layer.
NearLoss::NearLoss(const std::string& name, const Lattice4& lattice) {
  const bool bcc = lattice.space.bcc;
  const Kernel kernel = bcc ? make_kernel(name) : make_cc_kernel(name).kernel;
  planes_ = below(bcc ? kernel.space.radius * std::numbers::sqrt2 + 1 : kernel.space.radius + 0.5);
  if (!lattice.is_static()) layers_ = below(kernel.time.half_width / kernel_time_per_layer(lattice) + 1);
}

void NearLoss::mark(std::span<const Int3> lost, BrickLayer& layer) const {
  std::map<size_t, BrickMask> masks;
  for (const Int3& brick : lost) add_box(sites_around(brick, planes_, layer), layer, masks);
  for (const auto& [slot, holes] : masks) layer.set(slot, with_holes(layer.brick(slot), holes));
}

} // namespace bccsplat
