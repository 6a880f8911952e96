// SPDX-License-Identifier: Apache-2.0
// What samples of the moment lack of the sum along the ways becomes coefficients of its kernel, as every
// sample does, and these are added.
#include "motion/moved_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <span>
#include <vector>

#include "field/coefficients/coefficients.h"
#include "field/footprint/footprint.h"
#include "motion/occupied.h"
#include "motion/warped.h"
#include "points/sample_source.h"
#include "slice/largest_magnitude.h"

namespace bccsplat::motion {
namespace {

// Coefficients below this part of the largest are dropped: they are less than what a float holds of it.
constexpr float dropped = 0x1p-24f;
// Coefficients below this part of the largest are air: less than what files hold of values without options.
constexpr float unseen = 0x1p-10f;

// A slice as it goes on beyond its domain.
Slice without_end(const Slice& slice) {
  constexpr double anywhere = 1e9;
  Slice endless = slice;
  endless.domain_begin.fill(-anywhere), endless.domain_end.fill(anywhere);
  return endless;
}

float largest(const Slice& slice) {
  float most = 0;
  for (int c = 0; c < slice.lattice.cosets(); ++c)
    most = std::max(most, largest_magnitude(slice.coset[static_cast<size_t>(c)]));
  return most;
}

// From the lattice of the moment to the samples that the flow was found on, and back.
struct Places {
  Vec3 scale, offset;

  Places(const Slice& moment, const Int3& step) {
    for (size_t a = 0; a < 3; ++a) {
      scale[a] = moment.lattice_to_slice.linear[a][a] / step[a];
      offset[a] = moment.lattice_to_slice.offset[a] / step[a];
    }
  }
  [[nodiscard]] Float3 of(const Vec3& p) const {
    Float3 place;
    for (size_t a = 0; a < 3; ++a) place[a] = static_cast<float>(scale[a] * p[a] + offset[a]);
    return place;
  }
};

// Beyond the domain, its end, but for what is there by itself.
Vec3 moved(const Slice& moment, const Vec3& p, const Vec3& velocity, float ahead) {
  Vec3 q;
  for (size_t a = 0; a < 3; ++a)
    q[a] = std::clamp(p[a] + ahead * velocity[a], std::min(p[a], moment.domain_begin[a]),
                      std::max(p[a], moment.domain_end[a]));
  return q;
}

// A field that is looked at, and where it is air.
struct Field {
  Slice slice; // without an end
  Occupied occupied;
  FootprintPlan plan;

  Field(const Slice& of, float nothing)
      : slice(without_end(of)), occupied(of, nothing), plan({layers(slice), &slice.kernel}) {}
  Field(const Field&) = delete;

  // Adds weight times the values at some places.
  void add(std::span<const Vec3> places, float weight, std::span<float> sums) const {
    Batch batch;
    for (size_t i = 0; i < places.size(); ++i) {
      if (!occupied.at(places[i])) {
        sums[i] += weight * slice.base;
        continue;
      }
      batch.place[batch.count] = {places[i][0], places[i][1], places[i][2], 0};
      batch.which[batch.count++] = i;
      if (batch.count == batch_places) take(batch, weight, sums);
    }
    take(batch, weight, sums);
  }

 private:
  static constexpr size_t batch_places = 512;
  struct Batch {
    std::array<Vec4, batch_places> place;
    std::array<size_t, batch_places> which;
    size_t count = 0;
  };
  static std::vector<FieldLayer> layers(const Slice& of) {
    std::vector<FieldLayer> all;
    for (int c = 0; c < of.lattice.cosets(); ++c) all.push_back({&of.coset[static_cast<size_t>(c)]});
    return all;
  }
  void take(Batch& batch, float weight, std::span<float> sums) const {
    std::array<float, batch_places> values;
    sum_footprints(plan, std::span(batch.place).first(batch.count), values.data(), nullptr);
    for (size_t i = 0; i < batch.count; ++i) {
      const Vec4& p = batch.place[i];
      const bool hole = slice.has_holes && slice.is_hole({p[0], p[1], p[2]});
      sums[batch.which[i]] +=
          hole ? std::numeric_limits<float>::quiet_NaN() : weight * (slice.base + values[i]);
    }
    batch.count = 0;
  }
};
using Fields = std::deque<Field>;

// What the nodes say along a line of sites, between those around it.
struct NodeLine {
  struct Node {
    Float3 velocity{};
    float mask = 0;
  };
  std::vector<Node> node;
  int32_t first = 0;

  // from, to: places of the ends of the line.
  void set(const Interval& interval, const Float3& from, const Float3& to) {
    node.clear();
    const Nodes& nodes = interval.flow.nodes;
    const Between y = between(nodes, 1, from[1]), z = between(nodes, 2, from[2]);
    first = between(nodes, 0, from[0]).first;
    const int32_t last = between(nodes, 0, to[0]).second;
    for (int32_t x = first; x <= last; ++x) {
      Node sum;
      for (const int corner : {0, 1, 2, 3}) {
        const bool second_y = corner & 1, second_z = corner & 2;
        const float share = (second_y ? y.share : 1 - y.share) * (second_z ? z.share : 1 - z.share);
        const size_t i = nodes.index({x, second_y ? y.second : y.first, second_z ? z.second : z.first});
        sum.mask += share * interval.mask[i];
        for (size_t a = 0; a < 3; ++a) sum.velocity[a] += share * interval.flow.velocity[i][a];
      }
      node.push_back(sum);
    }
  }
  [[nodiscard]] Node at(const Nodes& nodes, float x) const {
    const Between b = between(nodes, 0, x);
    const Node &l = node[static_cast<size_t>(b.first - first)],
               &r = node[static_cast<size_t>(b.second - first)];
    Node sum{{}, (1 - b.share) * l.mask + b.share * r.mask};
    for (size_t a = 0; a < 3; ++a) sum.velocity[a] = (1 - b.share) * l.velocity[a] + b.share * r.velocity[a];
    return sum;
  }
};

// Sites of a brick that follow.
class Following {
 public:
  std::vector<int> site;
  std::vector<Vec3> at;       // lattice units
  std::vector<Vec3> velocity; // lattice units an interval
  std::vector<float> on;      // the mask

  // field: the moment's own.
  Following(const Slice& moment, const Field& field, const Fields& frames, const BrickLayer& layer,
            size_t slot, const MovedSum& sum)
      : moment_(moment), field_(field), frames_(frames), sum_(sum), places_(moment, sum.step),
        coset_(layer.coset()) {
    const Int3 first = layer.slot_position(slot);
    for (size_t a = 0; a < 3; ++a) {
      begin_[a] = first[a] * brick_edge;
      end_[a] = std::min(begin_[a] + brick_edge, layer.dims()[a]);
    }
    constexpr int32_t edge = 4; // of the blocks that are left out where all is air
    for (int32_t z = begin_[2]; z < end_[2]; z += edge)
      for (int32_t y = begin_[1]; y < end_[1]; y += edge)
        for (int32_t x = begin_[0]; x < end_[0]; x += edge)
          add_block({x, y, z},
                    {std::min(x + edge, end_[0]), std::min(y + edge, end_[1]), std::min(z + edge, end_[2])});
  }

 private:
  // Whether a node follows of those around a box of places, and what velocities it may meet.
  struct Reach {
    bool follows = false;
    Vec3 least{}, most{}; // lattice units an interval

    Reach(const Interval& interval, const Places& places, const Float3& low, const Float3& high) {
      const Nodes& nodes = interval.flow.nodes;
      Int3 first, last;
      for (size_t a = 0; a < 3; ++a)
        first[a] = between(nodes, a, low[a]).first, last[a] = between(nodes, a, high[a]).second;
      for (int32_t z = first[2]; z <= last[2]; ++z)
        for (int32_t y = first[1]; y <= last[1]; ++y)
          for (int32_t x = first[0]; x <= last[0]; ++x) {
            const size_t i = nodes.index({x, y, z});
            follows = follows || interval.mask[i] > 0;
            for (size_t a = 0; a < 3; ++a) {
              const double v = interval.flow.velocity[i][a] / places.scale[a];
              least[a] = std::min(least[a], v), most[a] = std::max(most[a], v);
            }
          }
    }
  };
  void add_block(const Int3& begin, const Int3& end) {
    const Vec3 low = moment_.site(coset_, begin),
               high = moment_.site(coset_, {end[0] - 1, end[1] - 1, end[2] - 1});
    const Reach reach(sum_.interval, places_, places_.of(low), places_.of(high));
    if (!reach.follows || air(low, high, reach)) return;
    for (int32_t z = begin[2]; z < end[2]; ++z)
      for (int32_t y = begin[1]; y < end[1]; ++y) {
        line_.set(sum_.interval, places_.of(moment_.site(coset_, {begin[0], y, z})),
                  places_.of(moment_.site(coset_, {end[0] - 1, y, z})));
        for (int32_t x = begin[0]; x < end[0]; ++x)
          add(((z - begin_[2]) * brick_edge + y - begin_[1]) * brick_edge + x - begin_[0],
              moment_.site(coset_, {x, y, z}));
      }
  }
  [[nodiscard]] bool air(const Vec3& low, const Vec3& high, const Reach& reach) const {
    if (field_.occupied.within(low, high)) return false;
    for (size_t k = 0; k < frames_.size(); ++k) {
      const float ahead = sum_.frames[k].ahead;
      const Vec3 &back = ahead < 0 ? reach.most : reach.least, &forth = ahead < 0 ? reach.least : reach.most;
      if (frames_[k].occupied.within(moved(moment_, low, back, ahead), moved(moment_, high, forth, ahead)))
        return false;
    }
    return true;
  }
  void add(int number, const Vec3& p) {
    const Flow& flow = sum_.interval.flow;
    const Float3 place = places_.of(p);
    const NodeLine::Node node = line_.at(flow.nodes, place[0]);
    if (node.mask <= 0) return;
    const Float3 v = velocity_at(flow, place, node.velocity, sum_.halfway);
    site.push_back(number), at.push_back(p), on.push_back(node.mask);
    velocity.push_back({v[0] / places_.scale[0], v[1] / places_.scale[1], v[2] / places_.scale[2]});
  }

  const Slice& moment_;
  const Field& field_;
  const Fields& frames_;
  const MovedSum& sum_;
  Places places_;
  int coset_;
  NodeLine line_; // that of the sites at hand
  Int3 begin_{}, end_{};
};

// What the samples of a brick lack; null where that is nothing.
std::shared_ptr<Brick> lacking(const Slice& moment, const Field& field, const Fields& frames,
                               const BrickLayer& layer, size_t slot, const MovedSum& sum) {
  const Following here(moment, field, frames, layer, slot, sum);
  if (here.site.empty()) return nullptr;
  std::vector<float> lacks(here.site.size());
  field.add(here.at, -1, lacks);
  std::vector<Vec3> there(here.site.size());
  for (size_t k = 0; k < frames.size(); ++k) {
    const MovedFrame& f = sum.frames[k];
    for (size_t i = 0; i < there.size(); ++i) there[i] = moved(moment, here.at[i], here.velocity[i], f.ahead);
    frames[k].add(there, f.weight, lacks);
  }
  auto brick = std::make_shared<Brick>();
  for (size_t i = 0; i < lacks.size(); ++i) // where something is missing the moment stays
    if (!std::isnan(lacks[i])) brick->value[static_cast<size_t>(here.site[i])] = here.on[i] * lacks[i];
  return brick->keep_above(0) > 0 ? brick : nullptr;
}

// Coefficients of samples on a moment's lattice.
std::vector<std::shared_ptr<const BrickLayer>> filtered(const Slice& moment, std::vector<BrickLayer> samples,
                                                        const Context& context) {
  Lattice4 lattice;
  lattice.kind = moment.lattice.bcc ? LatticeKind::bcc : LatticeKind::cc;
  lattice.space = moment.lattice, lattice.time_step = 0, lattice.last_layer = moment.lattice.cosets() - 1;
  for (size_t a = 0; a < 3; ++a) // only 1 or more matters here
    lattice.dims[a] = static_cast<uint32_t>(lattice.space.last[a]) + 1;
  float most = 0;
  for (const BrickLayer& l : samples) most = std::max(most, largest_magnitude(l));
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(samples));
  const MemorySamples source(lattice, {0}, std::move(channels));
  const Coefficients coefficients(source, 0, moment.kernel, most * dropped,
                                  std::numeric_limits<uint64_t>::max());
  std::vector<std::shared_ptr<const BrickLayer>> made;
  for (int c = 0; c < moment.lattice.cosets(); ++c) made.push_back(coefficients.layer(c, context));
  return made;
}

std::shared_ptr<const Brick> sum_of(const Brick* brick, const Brick& added) {
  auto both = std::make_shared<Brick>();
  both->value = added.value, both->kept = added.kept;
  if (!brick) return both;
  for (size_t i = 0; i < brick_sites; ++i) both->value[i] += brick->value[i];
  for (size_t r = 0; r < brick_rows; ++r)
    both->kept[r] = static_cast<uint16_t>(both->kept[r] | brick->kept[r]);
  if (brick->hole) both->hole = std::make_unique<BrickMask>(*brick->hole);
  return both;
}

} // namespace

void follow_ways(Slice& moment, const MovedSum& sum, const Context& context) {
  moment.coset.make(context);
  const float nothing = unseen * largest(moment);
  const Field field(moment, nothing);
  Fields frames;
  for (const MovedFrame& f : sum.frames) frames.emplace_back(*f.slice, nothing);
  std::vector<BrickLayer> samples;
  SharedReservation memory(context.memory);
  for (int c = 0; c < moment.lattice.cosets(); ++c) {
    BrickLayer layer(moment.lattice, c);
    context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
      context.progress.check();
      auto brick = lacking(moment, field, frames, layer, slot, sum);
      if (brick) memory.add(3 * sizeof(Brick), "a moment that follows"); // its coefficients, and the sum
      layer.set(slot, std::move(brick));
    });
    samples.push_back(std::move(layer));
  }
  if (std::all_of(samples.begin(), samples.end(), [](const BrickLayer& l) { return l.bricks() == 0; }))
    return;
  const auto added = filtered(moment, std::move(samples), context);
  for (int c = 0; c < moment.lattice.cosets(); ++c) {
    BrickLayer& layer = moment.coset[static_cast<size_t>(c)];
    const BrickLayer& more = *added[static_cast<size_t>(c)];
    context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
      if (const Brick* const b = more.brick(slot)) layer.set(slot, sum_of(layer.brick(slot), *b));
    });
  }
  moment.bounds = coefficient_bounds(moment);
}

} // namespace bccsplat::motion
