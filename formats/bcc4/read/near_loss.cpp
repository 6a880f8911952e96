// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/read/near_loss.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "kernel/cc_kernel.h"
#include "kernel/kernel_time.h"

namespace bccsplat {
namespace {

// The largest whole number below x.
int32_t below(double x) { return static_cast<int32_t>(std::ceil(x - 1e-9)) - 1; }

// Sites of a layer, by axis.
using SitesByAxis = std::array<std::vector<int32_t>, 3>;

// The sites of a layer within `planes` planes of a brick of either coset, along periodic axes across their
// ends.
SitesByAxis sites_around(const Int3& brick, int32_t planes, const BrickLayer& layer) {
  const Lattice3& lattice = layer.lattice();
  const int32_t width = brick_edge * (lattice.bcc ? 2 : 1);
  SitesByAxis sites;
  for (size_t a = 0; a < 3; ++a)
    for (int32_t site = 0; site < layer.dims()[a]; ++site) {
      const int32_t at = lattice.plane(layer.coset(), site),
                    turn = lattice.periodic[a] ? lattice.last[a] + 1 : 0;
      const auto near = [&](int32_t plane) {
        return plane >= brick[a] * width - planes && plane < (brick[a] + 1) * width + planes;
      };
      if (near(at) || near(at - turn) || near(at + turn)) sites[a].push_back(site);
    }
  return sites;
}

// Adds them to the masks of their bricks, by slot.
void add_sites(const SitesByAxis& sites, const BrickLayer& layer, std::map<size_t, BrickMask>& masks) {
  for (const int32_t z : sites[2])
    for (const int32_t y : sites[1])
      for (const int32_t x : sites[0]) {
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
  for (const Int3& brick : lost) add_sites(sites_around(brick, planes_, layer), layer, masks);
  for (const auto& [slot, holes] : masks) layer.set(slot, with_holes(layer.brick(slot), holes));
}

} // namespace bccsplat
