// SPDX-License-Identifier: Apache-2.0
// Makes layers in stretches, some rows of bricks along z at a time, where the cache is too small for what
// whole layers are made of.
#include <algorithm>
#include <limits>

#include "field/coefficients/coefficients.h"
#include "points/rounded_brick.h"

namespace bccsplat {
namespace {

// Rows of bricks beside a stretch that its coefficients may depend on: no prefilter reaches 16 sites.
constexpr int stretch_margin = 1;
// Rows of bricks that stay at the end of a periodic z: the very last one may have few sites.
constexpr int last_rows = 2;

// What stretches may take of the cache.
uint64_t stretch_bytes(uint64_t limit) { return limit - limit / 4; }

// Whether the first rows of bricks along z depend on the last ones: a box that reaches an end of a periodic
// axis goes all the way (go_round).
bool stretches_go_round(const Lattice3& lattice, const BrickBox& region) {
  return lattice.periodic[2] && region.begin[2] == 0;
}

// Adds the bricks of a part of a layer; returns what they take.
uint64_t take_bricks(const SampleLayer& part, SampleLayer& layer) {
  uint64_t bytes = 0;
  for (size_t s = 0; s < layer.brick_slots(); ++s) {
    if (!part.brick(s)) continue;
    layer.set(s, part.share(s));
    bytes += part.brick(s).bytes();
  }
  return bytes;
}

} // namespace

// Some rows of bricks along z of layers of samples, which move on. Where z is periodic, the first rows depend
// on the last ones, and these on the first: they stay.
class Coefficients::SampleRows {
 public:
  SampleRows(const Coefficients& owner, const std::set<int32_t>& layers)
      : owner_(owner), numbers_(layers.begin(), layers.end()) {
    const Lattice4& lattice = owner.source_.lattice();
    for (const int32_t m : layers)
      pointers_[m] = &layers_.emplace(m, SampleLayer(lattice.space, lattice.coset(m))).first->second;
    if (!stretches_go_round(lattice.space, owner.region_)) return;
    first_stay_ = stretch_margin;
    last_stay_ = layers_.begin()->second.brick_dims()[2] - last_rows;
  }
  [[nodiscard]] const std::map<int32_t, const SampleLayer*>& layers() const { return pointers_; }

  // Drops rows before `begin` and reads those before `end` that are not there. Neither ever falls.
  void move(int begin, int end, const Context& context) {
    for (auto& [m, layer] : layers_) {
      for (size_t s = 0; s < layer.brick_slots(); ++s)
        if (const int z = layer.slot_position(s)[2]; z >= first_stay_ && z < std::min(begin, last_stay_))
          layer.set(s, {});
      hold(m, layer, context);
    }
    if (end_ == 0 && last_stay_ < INT32_MAX) read(std::max(last_stay_, 0), INT32_MAX, context);
    read(std::max(begin, end_), std::min(end, last_stay_), context);
    end_ = end;
  }

 private:
  void read(int begin, int end, const Context& context) {
    BrickBox box = owner_.read_region_;
    box.begin[2] = std::max(box.begin[2], begin), box.end[2] = std::min(box.end[2], end);
    if (box.begin[2] >= box.end[2]) return;
    const auto take = [&](int32_t m, SampleLayer&& read) {
      SampleLayer& layer = layers_.at(m);
      for (size_t s = 0; s < layer.brick_slots(); ++s)
        if (const int z = layer.slot_position(s)[2]; z >= box.begin[2] && z < box.end[2])
          layer.set(s, read.share(s));
      hold(m, layer, context);
    };
    owner_.source().read_samples(owner_.channel_, numbers_, box, context, take);
  }
  void hold(int32_t m, const SampleLayer& layer, const Context& context) {
    held_[m] = {};
    held_[m] = Reservation(context.memory, layer.bytes(), "samples of a slab");
  }

  const Coefficients& owner_;
  std::vector<int32_t> numbers_;
  std::map<int32_t, SampleLayer> layers_;
  std::map<int32_t, const SampleLayer*> pointers_;
  std::map<int32_t, Reservation> held_;
  int first_stay_ = 0, last_stay_ = INT32_MAX; // rows before the one and from the other on stay
  int end_ = 0;
};

double Coefficients::stretch_rows(std::span<const int32_t> layers, const Context& context) const {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  if (source_.lattice().is_static()) return unlimited;
  const size_t samples = prefilter_->reads(layers).size();
  // Coefficients spread a few sites beyond the samples: half as many bricks again, at most all.
  Progress unheard(context.progress, 0, 0);
  const auto one = read(Kind::samples, layers.first(1), context.with(unheard)).begin()->second;
  const double stand = std::max<double>(1, static_cast<double>(one->bricks())),
               share = std::min(1.5, static_cast<double>(one->brick_slots()) / stand);
  const double all = share * static_cast<double>(one->bytes() * samples);
  if (all <= static_cast<double>(limit_)) return unlimited;
  const int height = one->brick_dims()[2];
  const int beside = 2 * stretch_margin +
                     (stretches_go_round(source_.lattice().space, region_) ? stretch_margin + last_rows : 0);
  return std::min<double>(static_cast<double>(stretch_bytes(limit_)) * height / all - beside, height);
}

Coefficients::Layers Coefficients::make_by_stretches(std::span<const int32_t> layers, int rows,
                                                     const Context& context) const {
  const Lattice4& lattice = source_.lattice();
  std::vector<SampleLayer> made;
  int height = 0;
  for (const int32_t m : layers)
    height = std::max(height, made.emplace_back(lattice.space, lattice.coset(m)).brick_dims()[2]);
  {
    const std::scoped_lock lock(mutex_);
    spared_.clear();
    evict_locked(stretch_bytes(limit_));
  }
  const std::set<int32_t> reads = prefilter_->reads(layers);
  count_repeats(Kind::samples, std::vector(reads.begin(), reads.end()));
  SampleRows samples(*this, reads);
  std::vector<Reservation> parts; // of the bricks that stay when a stretch's own store goes
  const int end = std::min(height, region_.end[2]);
  for (int z = region_.begin[2]; z < end; z += rows) {
    BrickBox stretch = region_;
    stretch.begin[2] = z, stretch.end[2] = std::min(end, z + rows);
    Progress share(context.progress, 1.0 * z / height, 1.0 * stretch.end[2] / height);
    samples.move(z - stretch_margin, stretch.end[2] + stretch_margin, context.with(share));
    const auto part =
        prefilter_->apply(layers, samples.layers(), {prune_, coarsest_}, stretch, context.with(share));
    uint64_t bytes = 0;
    for (size_t i = 0; i < made.size(); ++i) bytes += take_bricks(part[i], made[i]);
    parts.emplace_back(context.memory, bytes, "coefficients of a slab");
  }
  parts.clear();
  return insert_all(Kind::compact, layers, std::move(made), context);
}

std::vector<SampleLayer> Coefficients::make_of_sums(std::span<const LayerSum> sums, float coarsest,
                                                    const Context& context) const {
  const Lattice4& lattice = source_.lattice();
  std::vector<SampleLayer> made;
  uint64_t bricks = 1; // of a layer
  for (const LayerSum& sum : sums) {
    std::vector<int32_t> summed;
    for (const LayerSum::Term& term : sum.terms) summed.push_back(term.layer);
    made.emplace_back(lattice.space, lattice.coset(sum.layer));
    bricks = std::max(bricks, source_.bricks_at_most(channel_, summed, read_region_));
  }
  const int first = region_.begin[2], last = std::min(made.front().brick_dims()[2], region_.end[2]);
  // The layers, and beside them one that is being made; the prefilter reserves its own.
  const uint64_t each = coarsest > 0 ? sizeof(RoundedBrick) : sizeof(Brick),
                 bytes = bricks * (sums.size() * each + sizeof(Brick));
  int rows = std::max(last - first, 1); // of bricks along z, at a time
  if (bytes > limit_) {
    const double fit = static_cast<double>(stretch_bytes(limit_)) / static_cast<double>(bytes);
    rows = std::max(1, static_cast<int>(fit * rows) - 2 * stretch_margin);
  }
  {
    const std::scoped_lock lock(mutex_);
    evict_useless_locked(std::min(bytes, limit_));
  }
  std::vector<Reservation> parts; // of the bricks that stay
  for (int z = first; z < last; z += rows) {
    BrickBox stretch = region_;
    stretch.begin[2] = z, stretch.end[2] = std::min(last, z + rows);
    const BrickBox around = go_round(stretch.widened(), lattice.space);
    const double all = last - first, share_first = (z - first) / all,
                 share_end = (stretch.end[2] - first) / all;
    Progress share(context.progress, share_first, share_end);
    const double part =
        std::min(1.0, (std::min(around.end[2], last) - std::max(around.begin[2], first)) / all);
    const auto reserved = static_cast<uint64_t>(static_cast<double>(bytes) * part);
    const Reservation room = reserve(reserved, "sums of layers", context);
    uint64_t stays = 0;
    Reservation more; // where bricks hold values that 16 bits do not
    for (size_t i = 0; i < sums.size(); ++i) {
      const double at = static_cast<double>(i), n = static_cast<double>(sums.size());
      Progress adding(share, at / n, (at + 0.5) / n), filtering(share, (at + 0.5) / n, (at + 1) / n);
      BrickLayer sum =
          std::move(source_.add_layers(channel_, sums.subspan(i, 1), around, context.with(adding)).front());
      adding.advance(1, 1);
      stays += take_bricks(in_space_->apply_to(sums[i].layer, std::move(sum), {prune_, coarsest}, stretch,
                                               context.with(filtering)),
                           made[i]);
      if (stays > reserved) more = {}, more = Reservation(context.memory, stays - reserved, "sums of layers");
      filtering.advance(1, 1);
    }
    if (stretch.end[2] < last) parts.emplace_back(context.memory, stays, "coefficients of a slab");
  }
  parts.clear();
  return made;
}

} // namespace bccsplat
