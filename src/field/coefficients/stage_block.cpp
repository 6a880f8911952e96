#include "field/coefficients/stage_block.h"

#include <algorithm>

#include "field/footprint/patch.h"

namespace bccsplat {
namespace {

const float* values_of(const BrickLayer& layer, const Int3& b, bool& any) {
  for (size_t a = 0; a < 3; ++a)
    if (b[a] >= layer.brick_dims()[a]) return air_brick(); // the other coset may have one brick less
  const Brick* brick = layer.brick(b[0], b[1], b[2]);
  if (!brick) return air_brick();
  any = true;
  return brick->value.data();
}

void add_term(const BrickLayer* layer, double centre, double neighbours, const Int3& b, const Int3& low_brick,
              const Int3& high_brick, StageBlock& block) {
  if (!layer || (centre == 0 && neighbours == 0)) return;
  StageTerm t{static_cast<float>(centre), static_cast<float>(neighbours), nullptr, {}, {}};
  bool any = false;
  t.own = values_of(*layer, b, any);
  for (size_t a = 0; a < 3 && neighbours != 0; ++a) {
    Int3 low = b, high = b;
    low[a] = low_brick[a], high[a] = high_brick[a];
    t.low[a] = values_of(*layer, low, any), t.high[a] = values_of(*layer, high, any);
  }
  if (!any) return;
  block.term[static_cast<size_t>(block.terms++)] = t;
}

// Numbers of the up to three bricks along each axis; absent ones repeat the first.
using Thirds = std::array<std::array<int, 3>, 3>;

// Places the sites around those of brick b.
Thirds place_cross(const BrickLayer& layer, bool same_lattice, const Int3& b, const Int3& width,
                   StageCross& cross) {
  cross.span = same_lattice ? 2 : 1;
  cross.shift = same_lattice || layer.coset() == 1 ? -1 : 0;
  Thirds bricks;
  for (size_t a = 0; a < 3; ++a) {
    bricks[a].fill(b[a]);
    size_t count = 1;
    StageCross::Axis axis{};
    for (int i = 0; i < width[a] + cross.span; ++i) {
      const int local = i + cross.shift;
      int at = b[a] * brick_edge + local;
      if (at < 0 || at >= layer.dims()[a]) at = layer.lattice().mirror(a, layer.coset(), at);
      const int brick = at / brick_edge, site = at % brick_edge;
      size_t third = 0;
      while (third < count && bricks[a][third] != brick) ++third;
      if (third == count) bricks[a][count++] = brick;
      const auto k = static_cast<size_t>(i);
      axis.third[k] = static_cast<uint8_t>(third), axis.site[k] = static_cast<uint8_t>(site);
      if (a == 0 && (third != 0 || site != local))
        cross.patch[static_cast<size_t>(cross.patches++)] = {i, static_cast<int>(third), site};
    }
    if (a == 1) cross.y = axis;
    if (a == 2) cross.z = axis;
  }
  return bricks;
}

void add_cross(const BrickLayer* layer, const Thirds& bricks, StageCross& cross) {
  if (!layer) return;
  bool any = false;
  auto& values = cross.brick[static_cast<size_t>(cross.layers)];
  for (size_t z = 0; z < 3; ++z)
    for (size_t y = 0; y < 3; ++y)
      for (size_t x = 0; x < 3; ++x)
        values[z][y][x] = values_of(*layer, {bricks[0][x], bricks[1][y], bricks[2][z]}, any);
  cross.layers += any;
}

} // namespace

StageBlock stage_block(const PrefilterStage& stage, const StageInput& in, const Int3& b) {
  StageBlock block;
  const BrickLayer& own = *in.previous.own;
  Int3 low_brick, high_brick;
  for (size_t a = 0; a < 3; ++a) {
    const int origin = b[a] * brick_edge;
    block.width[a] = std::min(brick_edge, own.dims()[a] - origin);
    const int low = own.lattice().mirror(a, own.coset(), origin - 1);
    const int high = own.lattice().mirror(a, own.coset(), origin + block.width[a]);
    low_brick[a] = low / brick_edge, block.low_site[a] = low % brick_edge;
    high_brick[a] = high / brick_edge, block.high_site[a] = high % brick_edge;
  }
  const auto add = [&](const BrickLayer* layer, double centre, double neighbours) {
    add_term(layer, centre, neighbours, b, low_brick, high_brick, block);
  };
  add(in.previous.own, stage.self, stage.spatial);
  add(in.previous.before, stage.temporal, stage.mixed);
  add(in.previous.after, stage.temporal, stage.mixed);
  add(in.samples.own, stage.source, stage.source_spatial);
  add(in.samples.before, stage.source_temporal, stage.source_mixed);
  add(in.samples.after, stage.source_temporal, stage.source_mixed);
  const auto end = block.term.begin() + block.terms;
  const auto split =
      std::stable_partition(block.term.begin(), end, [](const StageTerm& t) { return t.neighbours != 0; });
  block.neighbour_terms = static_cast<int>(split - block.term.begin());
  if (stage.cross != 0 && in.cross_after) {
    block.cross.weight = static_cast<float>(stage.cross);
    const Thirds bricks = place_cross(*in.cross_after, !own.lattice().bcc, b, block.width, block.cross);
    add_cross(in.cross_before, bricks, block.cross);
    add_cross(in.cross_after, bricks, block.cross);
  }
  return block;
}

} // namespace bccsplat
