// SPDX-License-Identifier: Apache-2.0
// Holds a frame's mask as bits, with counts of blocks summed along all axes, so that a box takes eight of
// them. Where the file is damaged and read in spite of it, the nearest whole mask in time stands for a lost
// one.
#include "field/masks.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "base/damage.h"
#include "base/would_block.h"

namespace bccsplat {
namespace {

constexpr uint64_t block_points = 4096; // of a task

uint64_t voxels_of(const std::array<int64_t, 3>& n) { return static_cast<uint64_t>(n[0]) * n[1] * n[2]; }

uint64_t words_of(const std::array<int64_t, 3>& n) { return (voxels_of(n) + 63) / 64; }

uint64_t corners_of(const std::array<int64_t, 3>& blocks) {
  return voxels_of({blocks[0] + 1, blocks[1] + 1, blocks[2] + 1});
}

} // namespace

int64_t counted_sample(double position) {
  constexpr double most = 1e15;
  return static_cast<int64_t>(std::clamp(nearest_place(position), -most, most));
}

std::array<int64_t, 3> FrameMask::blocks_of(const std::array<int64_t, 3>& samples) {
  std::array<int64_t, 3> blocks;
  for (size_t a = 0; a < 3; ++a) blocks[a] = (samples[a] + block_edge - 1) / block_edge;
  return blocks;
}

FrameMask::FrameMask(const std::array<int64_t, 3>& samples, Reservation memory, bool all)
    : n_(samples), blocks_(blocks_of(samples)), bits_(words_of(samples)), before_(corners_of(blocks_)),
      memory_(std::move(memory)) {
  if (!all) return;
  add(0, voxels_of(n_));
  count_blocks();
}

uint64_t FrameMask::bytes_of(const std::array<int64_t, 3>& samples) {
  return (words_of(samples) + corners_of(blocks_of(samples))) * sizeof(uint64_t);
}

size_t FrameMask::before_at(int64_t bx, int64_t by, int64_t bz) const {
  return (bz * (blocks_[1] + 1) + by) * (blocks_[0] + 1) + bx;
}
uint64_t& FrameMask::before(int64_t bx, int64_t by, int64_t bz) { return before_[before_at(bx, by, bz)]; }
uint64_t FrameMask::before(int64_t bx, int64_t by, int64_t bz) const {
  return before_[before_at(bx, by, bz)];
}

void FrameMask::count_blocks() {
  for (size_t w = 0; w < bits_.size(); ++w)
    for (uint64_t bits = bits_[w]; bits != 0;) {
      // A run of ones of the word, as far as it stays in a block.
      const int64_t from = std::countr_zero(bits);
      const auto i = static_cast<int64_t>(w * 64) + from, x = i % n_[0], row = i / n_[0];
      const int64_t room = std::min(block_edge - x % block_edge, n_[0] - x);
      const int64_t run = std::min<int64_t>(room, std::countr_one(bits >> from));
      before(x / block_edge + 1, row % n_[1] / block_edge + 1, row / n_[1] / block_edge + 1) += run;
      bits &= from + run == 64 ? 0 : ~uint64_t{0} << (from + run);
    }
  // Sums along one axis after the other.
  for (int64_t z = 1; z <= blocks_[2]; ++z)
    for (int64_t y = 1; y <= blocks_[1]; ++y)
      for (int64_t x = 1; x <= blocks_[0]; ++x) before(x, y, z) += before(x - 1, y, z);
  for (int64_t z = 1; z <= blocks_[2]; ++z)
    for (int64_t y = 1; y <= blocks_[1]; ++y)
      for (int64_t x = 1; x <= blocks_[0]; ++x) before(x, y, z) += before(x, y - 1, z);
  for (int64_t z = 1; z <= blocks_[2]; ++z)
    for (int64_t y = 1; y <= blocks_[1]; ++y)
      for (int64_t x = 1; x <= blocks_[0]; ++x) before(x, y, z) += before(x, y, z - 1);
}

uint64_t FrameMask::row_bits(const std::array<int64_t, 3>& first, int64_t count) const {
  const uint64_t i = (first[2] * n_[1] + first[1]) * n_[0] + first[0];
  const uint64_t from = i % 64, n = count;
  uint64_t bits = bits_[i / 64] >> from;
  if (from + n > 64) bits |= bits_[i / 64 + 1] << (64 - from);
  return n == 64 ? bits : bits & ((uint64_t{1} << n) - 1);
}

Missing FrameMask::within(const std::array<int64_t, 3>& first, const std::array<int64_t, 3>& last) const {
  constexpr int64_t most_rows = 32;
  const Missing blocks = within_blocks(first, last);
  const int64_t count = last[0] - first[0] + 1;
  if (blocks != Missing::some || count > 64 ||
      (last[1] - first[1] + 1) * (last[2] - first[2] + 1) > most_rows)
    return blocks;
  uint64_t any = 0, all = ~uint64_t{0} >> (64 - count);
  const uint64_t whole = all;
  for (int64_t z = first[2]; z <= last[2]; ++z)
    for (int64_t y = first[1]; y <= last[1]; ++y) {
      const uint64_t bits = row_bits({first[0], y, z}, count);
      any |= bits, all &= bits;
      if (any != 0 && all != whole) return Missing::some;
    }
  return any == 0 ? Missing::none : Missing::all;
}

Missing FrameMask::within_blocks(const std::array<int64_t, 3>& first,
                                 const std::array<int64_t, 3>& last) const {
  std::array<int64_t, 3> b, e;
  uint64_t samples = 1;
  for (size_t a = 0; a < 3; ++a) {
    b[a] = first[a] / block_edge, e[a] = last[a] / block_edge + 1;
    samples *= std::min(e[a] * block_edge, n_[a]) - b[a] * block_edge;
  }
  const auto column = [&](int64_t x, int64_t y) { return before(x, y, e[2]) - before(x, y, b[2]); };
  const uint64_t missing = column(e[0], e[1]) - column(b[0], e[1]) - column(e[0], b[1]) + column(b[0], b[1]);
  return missing == 0 ? Missing::none : missing == samples ? Missing::all : Missing::some;
}

void FrameMask::add(uint64_t begin, uint64_t end) {
  for (uint64_t i = begin; i < end;) {
    const uint64_t from = i % 64, n = std::min(end - i, 64 - from);
    bits_[i / 64] |= (n == 64 ? ~uint64_t{0} : (uint64_t{1} << n) - 1) << from;
    i += n;
  }
}

uint64_t FrameMask::count() const {
  uint64_t sum = 0;
  for (const uint64_t bits : bits_) sum += std::popcount(bits);
  return sum;
}

Masks::Masks(std::unique_ptr<const MaskSource> source, MemoryBudget& budget, uint64_t cache_bytes)
    : source_(std::move(source)), budget_(budget), cache_(cache_bytes) {
  const Lattice4& lattice = source_->lattice();
  for (size_t a = 0; a < 4; ++a) n_[a] = lattice.dims[a], turning_[a] = lattice.turns(a);
}

int64_t Masks::nearest(double position, size_t axis) const {
  return turning_[axis] ? turned_sample(position, n_[axis]) : nearest_sample(position, n_[axis]);
}

int64_t Masks::counted_frame(double moment) const {
  return turning_[3] ? counted_sample(moment) : nearest(moment, 3);
}

FrameMaskPtr Masks::read(int64_t frame, uint64_t offset) const {
  if (auto found = cache_.find(offset)) return found;
  const std::scoped_lock lock(mutex_);
  if (auto held = in_use_[offset].lock()) return held;
  const std::array<int64_t, 3> n{n_[0], n_[1], n_[2]};
  auto made = std::make_shared<FrameMask>(n, Reservation(budget_, FrameMask::bytes_of(n), "a mask"), false);
  source_->read_runs(frame, [&](uint64_t begin, uint64_t end) { made->add(begin, end); });
  made->count_blocks();
  in_use_[offset] = made;
  // The mask itself holds its memory.
  cache_.insert(offset, FrameMaskPtr(made), made->bytes(), 0);
  return made;
}

// Goes from the frame to those further and further off, until a mask is whole.
FrameMaskPtr Masks::frame(int64_t counted) const {
  const int64_t frame = source_->lattice().turned_frame(counted), end = n_[3];
  std::set<uint64_t> damaged;
  for (int64_t d = 0; d < end; ++d)
    for (const int64_t f : {frame + d, frame - d}) {
      if (f < 0 || f >= end) continue;
      const auto place = source_->place(f);
      if (!place) return nullptr;
      if (damaged.contains(place->offset)) continue;
      try {
        return read(f, place->offset);
      } catch (const Error& e) {
        if (!source_->goes_without(e)) throw;
        damaged.insert(place->offset);
      }
    }
  return nullptr;
}

void Masks::list_reads(int64_t first, int64_t last, bool missing, std::vector<ByteRange>& out) const {
  for (int64_t counted = first; counted <= last; ++counted) {
    const auto place = source_->place(source_->lattice().turned_frame(counted));
    if (!place) continue;
    const bool held = [&] {
      const std::scoped_lock lock(mutex_);
      const auto in_use = in_use_.find(place->offset);
      return cache_.contains(place->offset) || (in_use != in_use_.end() && !in_use->second.expired());
    }();
    if (!missing || !held) out.push_back(*place);
  }
}

uint64_t Masks::count() const {
  if (const auto told = source_->told_count()) return *told;
  std::map<uint64_t, uint64_t> of_block;
  uint64_t sum = 0;
  Attempts attempts;
  for (int64_t f = 0; f < n_[3]; ++f) {
    const auto place = source_->place(f);
    if (!place) continue;
    const auto [at, is_new] = of_block.try_emplace(place->offset, 0);
    uint64_t& missing = at->second;
    try {
      if (is_new) source_->read_runs(f, [&](uint64_t begin, uint64_t end) { missing += end - begin; });
    } catch (const WouldBlock& e) {
      attempts.add(e);
    } catch (const Error& e) {
      // What is damaged is found by a check of the file, or by whoever looks there.
      if (!is_damage(e.code()) && !source_->goes_without(e)) throw;
    }
    sum += missing;
  }
  attempts.throw_if_waiting();
  return sum;
}

template<class Body>
void Masks::each_missing(std::span<const Vec4> points, const Context& context, const Body& body) const {
  context.tasks.parallel_for((points.size() + block_points - 1) / block_points, [&](uint64_t b) {
    context.progress.check();
    std::optional<int64_t> held; // frame
    FrameMaskPtr mask;
    for (size_t i = b * block_points; i < std::min<size_t>(points.size(), (b + 1) * block_points); ++i) {
      const Vec4& p = points[i];
      const double t = n_[3] == 1 ? 0 : p[3]; // a static volume ignores it
      if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]) && std::isfinite(t))) continue;
      if (const int64_t f = counted_frame(t); f != held) mask = frame(f), held = f;
      if (mask && mask->at({nearest(p[0], 0), nearest(p[1], 1), nearest(p[2], 2)})) body(i);
    }
  });
}

uint64_t Masks::hide(std::span<const Vec4> points, std::span<float> values,
                     std::span<std::array<float, 4>> gradients, const Context& context) const {
  constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
  std::atomic<uint64_t> hidden{0};
  each_missing(points, context, [&](size_t i) {
    hidden += !std::isnan(values[i]);
    values[i] = nan_value;
    if (!gradients.empty()) gradients[i].fill(nan_value);
  });
  return hidden;
}

void Masks::mark(std::span<const Vec4> points, std::span<uint8_t> missing, const Context& context) const {
  each_missing(points, context, [&](size_t i) { missing[i] = 1; });
}

} // namespace bccsplat
