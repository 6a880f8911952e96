// SPDX-License-Identifier: Apache-2.0
// Goes along z once: loads the planes of samples ahead, mirrored beyond the lattice, makes a plane of each
// stage as soon as those it reads are there, and puts finished ones into bricks. The sums are made in
// stage_plane.cpp.
#include "field/coefficients/tile_planes.h"

#include <algorithm>
#include <cstring>

#include <hwy/cache_control.h>

#include "base/page_pool.h"
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

struct RowSpan {
  int first = 0, end = 0;
};

// Returns the first to the last row that has sites, of `count` rows of a plane of a brick from row y on.
RowSpan filled_rows(const SampleBrick& brick, int plane, int y, int count) {
  const BrickMask* kept = brick.kept();
  const BrickMask* hole = brick.hole();
  if (!kept) return {0, count};
  RowSpan rows{count, 0};
  for (int j = 0; j < count; ++j) {
    const size_t row = plane * brick_edge + y + j;
    if ((*kept)[row] == 0 && (!hole || (*hole)[row] == 0)) continue;
    rows = {std::min(rows.first, j), j + 1};
  }
  return rows;
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
    : region_(region), width_(std::max(0, region.end[0] - region.begin[0])),
      height_(std::max(0, region.end[1] - region.begin[1])),
      near_(width_ * height_ * std::max(0, region.end[2] - region.begin[2])) {
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
  for (int coset = 0; coset < space.cosets(); ++coset) runs_[coset] = {runs_of(0, coset), runs_of(1, coset)};
  bricks_.resize(plan.wanted() * ((tile.end[0] - tile.begin[0]) * (tile.end[1] - tile.begin[1])));
}

float* TilePlanes::at(const Ring& ring, int z) const {
  return memory_ + static_cast<std::ptrdiff_t>(plane_number(ring, z)) * size_.plane +
         size_.margin * (size_.stride + 1);
}

FilledBox TilePlanes::around(int margin) const {
  return {-margin, end_[0] - begin_[0] + margin, -margin, end_[1] - begin_[1] + margin};
}

void TilePlanes::fill_only(const FilledBox& box, const Ring& ring, int z) {
  FilledBox& was = filled(ring, z);
  const auto clear = [&](int y, int begin, int end) {
    if (begin < end) std::fill_n(at(ring, z) + y * size_.stride + begin, end - begin, 0.0f);
  };
  for (int y = was.first_y; y < was.end_y && !was.empty(); ++y) {
    if (box.empty() || y < box.first_y || y >= box.end_y) {
      clear(y, was.first_x, was.end_x);
      continue;
    }
    clear(y, was.first_x, std::min(was.end_x, box.first_x));
    clear(y, std::max(was.first_x, box.end_x), was.end_x);
  }
  was = box;
}

void TilePlanes::make(const std::map<int32_t, const SampleLayer*>& samples,
                      std::span<const TileLayer> outputs, const CoefficientForm& form,
                      const Progress& progress) {
  // The memory may hold planes of another tile.
  filled_.assign(plan_.planes(), around(size_.margin));
  const int ahead = plan_.margin();
  const auto& nodes = plan_.nodes();
  const size_t first_wanted = nodes.size() - plan_.wanted();
  for (int z = begin_[2] - 2 * ahead; z < end_[2]; ++z) {
    // Tiles of many layers take longer than a host wants to wait; it is asked between them.
    progress.throw_if_cancelled();
    if (z + ahead >= begin_[2] - ahead)
      for (const auto& [m, ring] : plan_.samples()) load(*samples.at(m), ring, z + ahead);
    for (size_t i = 0; i < nodes.size(); ++i) {
      step(nodes[i], z + nodes[i].margin);
      if (i >= first_wanted && z >= begin_[2])
        keep(nodes[i], i - first_wanted, outputs[i - first_wanted], z, form);
    }
  }
}

// Returns where the tile's sites along an axis and those around it lie in bricks, beyond the lattice as their
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
void TilePlanes::load(const SampleLayer& layer, size_t ring, int z) {
  const int plane = space_.mirror(2, layer.coset(), z);
  const auto& [along_x, along_y] = runs_[layer.coset()];
  const auto brick_of = [&](const Run& x, const Run& y) -> const SampleBrick& {
    return layer.brick(x.brick, y.brick, plane / brick_edge);
  };
  FilledBox box;
  for (const Run& y : along_y)
    for (const Run& x : along_x)
      if (const SampleBrick& brick = brick_of(x, y)) {
        const RowSpan rows = filled_rows(brick, plane % brick_edge, y.site, y.count);
        box.add({x.to, x.to + x.count, y.to + rows.first, y.to + rows.end});
      }
  fill_only(box, plan_.ring(ring), z);
  float* const to = at(ring, z);
  // Codes of a short run are written beyond its end (CodedBrick::read), where the next runs write 0 again, be
  // they outside the box.
  constexpr int beyond = brick_edge;
  for (const Run& y : along_y)
    for (const Run& x : along_x)
      if (box.meets({x.to - beyond, x.to + x.count, y.to, y.to + y.count}))
        load_run(brick_of(x, y), {plane % brick_edge, x.site, y.site, x.count, y.count},
                 to + y.to * size_.stride + x.to);
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
  FilledBox box;
  for (const Node::Input& i : node.inputs)
    if (i.centre != 0) box.add(filled(i.ring, z));
  for (int k = -1; k <= 1 && node.neighbour_inputs > 0; ++k)
    box.add(k == 0 ? filled(node.neighbours, z).seen(-1, 1) : filled(node.neighbours, z + k));
  if (!node.cross.empty())
    box.add(filled(node.corners, z + node.shift)), box.add(filled(node.corners, furthest));
  box = box.within(around(node.margin));
  fill_only(box, plan_.ring(node.ring), z);
  if (box.empty()) return;
  const std::ptrdiff_t offset = first(box);
  StagePlane plane;
  for (const Node::Input& i : node.inputs)
    if (i.centre != 0) plane.centre.add(at(i.ring, z) + offset, i.centre);
  if (plane.centre.count == 0) plane.centre.add(at(node.inputs.front().ring, z) + offset, 0);
  if (node.neighbour_inputs > 0)
    for (int k = 0; k < 3; ++k) plane.neighbours[k] = at(node.neighbours, z - 1 + k) + offset;
  if (!node.cross.empty()) {
    plane.corners = {at(node.corners, z + node.shift) + offset, at(node.corners, furthest) + offset};
    plane.cross = node.cross_weight;
  }
  sum_stage(plane, plane_box(box), at(node.ring, z) + offset);
}

void TilePlanes::sum_neighbours(const Node& node, int z) {
  FilledBox box;
  for (size_t i = 0; i < node.neighbour_inputs; ++i) box.add(filled(node.inputs[i].ring, z));
  box = box.within(around(node.margin + 1));
  fill_only(box, node.neighbours, z);
  if (box.empty()) return;
  const std::ptrdiff_t offset = first(box);
  PlaneTerms terms;
  for (size_t i = 0; i < node.neighbour_inputs; ++i)
    terms.add(at(node.inputs[i].ring, z) + offset, node.inputs[i].neighbours);
  sum_planes(terms, plane_box(box), at(node.neighbours, z) + offset);
}

void TilePlanes::sum_cross(const Node& node, int z) {
  FilledBox box;
  for (const size_t ring : node.cross) box.add(filled(ring, z).seen(node.shift, node.shift + node.span));
  box = box.within(around(node.margin));
  fill_only(box, node.corners, z);
  if (box.empty()) return;
  const std::ptrdiff_t offset = first(box), corner = node.shift * (size_.stride + 1) + offset;
  const float* second = node.cross.size() == 2 ? at(node.cross[1], z) + corner : nullptr;
  sum_corners(at(node.cross[0], z) + corner, second, node.span, plane_box(box), at(node.corners, z) + offset);
}

// Writes plane z of what a node made to the bricks of the tile, and hands over those that are complete.
void TilePlanes::keep(const Node& node, size_t output, const TileLayer& layer, int z,
                      const CoefficientForm& form) {
  const Int3& sites = layer.made->dims();
  const Int3& bricks = layer.made->brick_dims(); // the other coset may have one more
  Making* making = bricks_.data() + output * (bricks_.size() / plan_.wanted());
  const FilledBox& box = filled(node.ring, z);
  const int in_brick = z % brick_edge, bz = z / brick_edge;
  const bool last = z + 1 == end_[2] || in_brick + 1 == brick_edge;
  for (int by = tile_.begin[1]; by < std::min(tile_.end[1], bricks[1]); ++by)
    for (int bx = tile_.begin[0]; bx < std::min(tile_.end[0], bricks[0]) && bz < bricks[2]; ++bx, ++making) {
      if (in_brick == 0) {
        if (!making->brick) making->brick = make_pooled_for_overwrite<Brick>();
        making->any = false, making->planes = 0;
      }
      const int x = bx * brick_edge - begin_[0], y = by * brick_edge - begin_[1];
      if (box.meets({x, x + brick_edge, y, y + brick_edge}) && z < sites[2]) {
        making->fill_to(in_brick);
        making->any |= keep_plane(at(node.ring, z) + y * size_.stride + x,
                                  {sites[0] - bx * brick_edge, sites[1] - by * brick_edge, size_.stride},
                                  form.prune, making->brick->value.data() + in_brick * brick_rows,
                                  making->brick->kept.data() + in_brick * brick_edge);
        making->planes = in_brick + 1;
      }
      if (last) hand_over(*making, layer, layer.made->slot(bx, by, bz), form.coarsest);
    }
}

// Planes up to `end` that have not been written are 0.
void TilePlanes::Making::fill_to(int end) {
  std::fill(brick->value.begin() + planes * brick_rows, brick->value.begin() + end * brick_rows, 0.0f);
  std::fill(brick->kept.begin() + planes * brick_edge, brick->kept.begin() + end * brick_edge, uint16_t{0});
}

void TilePlanes::hand_over(Making& making, const TileLayer& layer, size_t slot, float coarsest) {
  Brick& brick = *making.brick;
  const BrickMask* hole = layer.samples->brick(slot).hole();
  if (!making.any && !hole) return;
  making.fill_to(brick_edge);
  brick.hole = hole ? std::make_unique<BrickMask>(*hole) : nullptr;
  if (coarsest > 0)
    if (auto rounded = RoundedBrick::round(brick, coarsest))
      return layer.made->set(slot, {nullptr, std::move(rounded)});
  layer.made->set(slot, {std::move(making.brick), nullptr});
}

} // namespace bccsplat
