// SPDX-License-Identifier: Apache-2.0
// Goes along z once: loads the planes of samples ahead, mirrored beyond the lattice, makes a plane of each
// stage as soon as those it reads are there, and puts finished ones into bricks. The sums are made in
// stage_plane.cpp.
#include "field/coefficients/tile_planes.h"

#include <algorithm>
#include <cstring>

#include <hwy/cache_control.h>

#include "points/rounded_brick.h"

namespace bccsplat {
namespace {

// Most rows are those of a whole brick.
void copy_sites(const float* from, int count, float* to) {
  if (count == brick_edge)
    std::memcpy(to, from, brick_edge * sizeof(float));
  else
    std::copy_n(from, count, to);
}

// The bricks along an axis of a region that are near a brick: it, those beside it, and of a periodic axis,
// whose last brick may be narrow, those that are so beyond its ends.
class NearAxis {
 public:
  NearAxis() = default;
  NearAxis(int brick, int bricks, bool turns, int begin, int end) {
    const auto add = [&](int b) {
      if (b >= begin && b < end) bricks_[count_++] = b;
    };
    if (turns && bricks <= 5) {
      for (int b = 0; b < bricks; ++b) add(b);
      return;
    }
    for (int b = brick - 1; b <= brick + 1; ++b)
      if (b >= 0 && b < bricks) add(b);
    if (turns && brick == 0) add(bricks - 2), add(bricks - 1);
    if (turns && brick >= bricks - 2) add(0);
  }
  [[nodiscard]] std::span<const int> all() const { return std::span(bricks_).first(count_); }

 private:
  std::array<int, 5> bricks_{};
  size_t count_ = 0;
};

} // namespace

NearBricks::NearBricks(const std::map<int32_t, const SampleLayer*>& samples, const BrickBox& region)
    : region_(region), width_(static_cast<size_t>(std::max(0, region.end[0] - region.begin[0]))),
      height_(static_cast<size_t>(std::max(0, region.end[1] - region.begin[1]))),
      near_(width_ * height_ * static_cast<size_t>(std::max(0, region.end[2] - region.begin[2]))) {
  for (const auto& [m, layer] : samples)
    for (size_t row = 0; row < layer->rows(); ++row) {
      if (layer->row_empty(row)) continue;
      for (size_t slot = row * layer->row_slots(); slot < (row + 1) * layer->row_slots(); ++slot) {
        if (!layer->brick(slot)) continue;
        const Int3 b = layer->slot_position(slot);
        std::array<NearAxis, 3> along;
        for (size_t a = 0; a < 3; ++a)
          along[a] = NearAxis(b[a], layer->brick_dims()[a], layer->lattice().periodic[a], region.begin[a],
                              region.end[a]);
        for (const int z : along[2].all())
          for (const int y : along[1].all())
            for (const int x : along[0].all()) near_[index(x, y, z)] = 1;
      }
    }
}

bool NearBricks::trim(BrickBox& box) const {
  BrickBox least{box.end, box.begin};
  bool any = false;
  for (int z = box.begin[2]; z < box.end[2]; ++z)
    for (int y = box.begin[1]; y < box.end[1]; ++y)
      for (int x = box.begin[0]; x < box.end[0]; ++x) {
        if (near_[index(x, y, z)] == 0) continue;
        any = true;
        const Int3 b{x, y, z};
        for (size_t a = 0; a < 3; ++a) {
          least.begin[a] = std::min(least.begin[a], b[a]);
          least.end[a] = std::max(least.end[a], b[a] + 1);
        }
      }
  box = least;
  return any;
}

TileSize::TileSize(const StagePlan& plan, const Int3& bricks) : margin(plan.margin()), planes(plan.planes()) {
  // A row ends with room for a vector that starts at its last site.
  stride = (bricks[0] + 1) * brick_edge + 2 * margin;
  plane = stride * (bricks[1] * brick_edge + 2 * margin);
}

TilePlanes::TilePlanes(const StagePlan& plan, const TileSize& size, const Lattice3& space,
                       const BrickBox& tile, float* memory)
    : plan_(plan), size_(size), space_(space), tile_(tile), memory_(memory) {
  const Int3 sites = space.dims(0); // the other coset has no more
  for (size_t a = 0; a < 3; ++a) {
    begin_[a] = tile.begin[a] * brick_edge;
    end_[a] = std::min(tile.end[a] * brick_edge, sites[a]);
  }
  for (int coset = 0; coset < space.cosets(); ++coset)
    runs_[static_cast<size_t>(coset)] = {runs_of(0, coset), runs_of(1, coset)};
  bricks_.resize(plan.wanted() *
                 static_cast<size_t>((tile.end[0] - tile.begin[0]) * (tile.end[1] - tile.begin[1])));
}

float* TilePlanes::at(const Ring& ring, int z) const {
  const int turn = ((z % ring.depth) + ring.depth) % ring.depth;
  return memory_ + static_cast<std::ptrdiff_t>(ring.first + static_cast<size_t>(turn)) * size_.plane -
         first(size_.margin);
}

PlaneBox TilePlanes::around(int margin) const {
  return {end_[0] - begin_[0] + 2 * margin, end_[1] - begin_[1] + 2 * margin, size_.stride};
}

void TilePlanes::make(const std::map<int32_t, const SampleLayer*>& samples,
                      std::span<const TileLayer> outputs, const CoefficientForm& form,
                      const Progress& progress) {
  const int ahead = plan_.margin();
  const auto& nodes = plan_.nodes();
  const size_t first_wanted = nodes.size() - plan_.wanted();
  for (int z = begin_[2] - 2 * ahead; z < end_[2]; ++z) {
    // Tiles of many layers take longer than a host wants to wait; it is asked between them.
    progress.throw_if_cancelled();
    if (z + ahead >= begin_[2] - ahead)
      for (const auto& [m, ring] : plan_.samples()) load(*samples.at(m), z + ahead, at(ring, z + ahead));
    for (size_t i = 0; i < nodes.size(); ++i) {
      step(nodes[i], z + nodes[i].margin);
      if (i >= first_wanted && z >= begin_[2])
        keep(nodes[i], i - first_wanted, outputs[i - first_wanted], z, form);
    }
  }
}

// Where the sites of the tile along an axis and those around it lie in bricks, beyond the lattice their
// mirror images or those at its other end.
std::vector<TilePlanes::Run> TilePlanes::runs_of(size_t axis, int coset) const {
  const int margin = plan_.margin();
  std::vector<Run> runs;
  int before = -1; // site
  for (int i = begin_[axis] - margin; i < end_[axis] + margin; ++i) {
    const int site = space_.mirror(axis, coset, i);
    const bool goes_on = !runs.empty() && site == before + 1 && site % brick_edge != 0;
    before = site;
    if (goes_on)
      ++runs.back().count;
    else
      runs.push_back({site / brick_edge, site % brick_edge, i - begin_[axis], 1});
  }
  return runs;
}

// The samples of plane z of the tile and its margins.
void TilePlanes::load(const SampleLayer& layer, int z, float* to) const {
  const int plane = space_.mirror(2, layer.coset(), z);
  const auto& [along_x, along_y] = runs_[static_cast<size_t>(layer.coset())];
  for (const Run& y : along_y)
    for (const Run& x : along_x)
      load_run(layer.brick(x.brick, y.brick, plane / brick_edge),
               {plane % brick_edge, x.site, y.site, x.count, y.count}, to + y.to * size_.stride + x.to);
}

// Bricks are far apart in memory, the rows of a plane of one are not.
void TilePlanes::load_run(const SampleBrick& brick, const PlanePart& part, float* to) const {
  if (brick.codes) return brick.codes->read(part, to, size_.stride);
  const float* from =
      brick.values ? brick.values->value.data() + (part.plane * brick_edge + part.y) * brick_edge + part.x
                   : nullptr;
  for (int j = 0; j < part.height; ++j, to += size_.stride)
    if (from) {
      copy_sites(from + j * brick_edge, part.width, to);
      hwy::Prefetch(from + j * brick_edge + brick_rows);
    } else
      std::fill_n(to, part.width, 0.0f);
}

// Makes plane z of a node, or of its sums what the first planes will need.
void TilePlanes::step(const Node& node, int z) {
  const int lowest = begin_[2] - node.margin;
  if (node.neighbour_inputs > 0 && z + 1 >= lowest - 1) sum_neighbours(node, z + 1);
  const int furthest = z + node.shift + node.span;
  if (!node.cross.empty() && furthest >= lowest + node.shift) sum_cross(node, furthest);
  if (z < lowest) return;
  const std::ptrdiff_t offset = first(node.margin);
  StagePlane plane;
  for (const Node::Input& i : node.inputs)
    if (i.centre != 0) plane.centre.add(at(i.ring, z) + offset, i.centre);
  if (plane.centre.count == 0) plane.centre.add(at(node.inputs.front().ring, z) + offset, 0);
  if (node.neighbour_inputs > 0)
    for (int k = 0; k < 3; ++k)
      plane.neighbours[static_cast<size_t>(k)] = at(node.neighbours, z - 1 + k) + offset;
  if (!node.cross.empty()) {
    plane.corners = {at(node.corners, z + node.shift) + offset, at(node.corners, furthest) + offset};
    plane.cross = node.cross_weight;
  }
  sum_stage(plane, around(node.margin), at(node.ring, z) + offset);
}

void TilePlanes::sum_neighbours(const Node& node, int z) {
  const std::ptrdiff_t offset = first(node.margin + 1);
  PlaneTerms terms;
  for (size_t i = 0; i < node.neighbour_inputs; ++i)
    terms.add(at(node.inputs[i].ring, z) + offset, node.inputs[i].neighbours);
  sum_planes(terms, around(node.margin + 1), at(node.neighbours, z) + offset);
}

void TilePlanes::sum_cross(const Node& node, int z) {
  const std::ptrdiff_t offset = first(node.margin), corner = node.shift * (size_.stride + 1) + offset;
  const float* second = node.cross.size() == 2 ? at(node.cross[1], z) + corner : nullptr;
  sum_corners(at(node.cross[0], z) + corner, second, node.span, around(node.margin),
              at(node.corners, z) + offset);
}

// Writes plane z of what a node made to the bricks of the tile, and hands over those that are complete.
void TilePlanes::keep(const Node& node, size_t output, const TileLayer& layer, int z,
                      const CoefficientForm& form) {
  const Int3& sites = layer.made->dims();
  const Int3& bricks = layer.made->brick_dims(); // the other coset may have one more
  Making* making = bricks_.data() + output * (bricks_.size() / plan_.wanted());
  const int in_brick = z % brick_edge, bz = z / brick_edge;
  const bool last = z + 1 == end_[2] || in_brick + 1 == brick_edge;
  for (int by = tile_.begin[1]; by < std::min(tile_.end[1], bricks[1]); ++by)
    for (int bx = tile_.begin[0]; bx < std::min(tile_.end[0], bricks[0]) && bz < bricks[2]; ++bx, ++making) {
      if (in_brick == 0) {
        if (!making->brick) making->brick = std::make_shared_for_overwrite<Brick>();
        making->any = false;
      }
      PlaneBox box{sites[0] - bx * brick_edge, sites[1] - by * brick_edge, size_.stride};
      if (z >= sites[2]) box.height = 0;
      const float* from =
          at(node.ring, z) + (by * brick_edge - begin_[1]) * size_.stride + bx * brick_edge - begin_[0];
      making->any |= keep_plane(from, box, form.prune, making->brick->value.data() + in_brick * brick_rows,
                                making->brick->kept.data() + in_brick * brick_edge);
      if (last) hand_over(*making, layer, layer.made->slot(bx, by, bz), in_brick + 1, form.coarsest);
    }
}

// planes: those that have been written.
void TilePlanes::hand_over(Making& making, const TileLayer& layer, size_t slot, int planes, float coarsest) {
  Brick& brick = *making.brick;
  std::fill(brick.value.begin() + planes * brick_rows, brick.value.end(), 0.0f);
  std::fill(brick.kept.begin() + planes * brick_edge, brick.kept.end(), uint16_t{0});
  const BrickMask* hole = layer.samples->brick(slot).hole();
  brick.hole = hole ? std::make_unique<BrickMask>(*hole) : nullptr;
  if (!making.any && !hole) return;
  if (coarsest > 0)
    if (auto rounded = RoundedBrick::round(brick, coarsest))
      return layer.made->set(slot, {nullptr, std::move(rounded)});
  layer.made->set(slot, {std::move(making.brick), nullptr});
}

} // namespace bccsplat
