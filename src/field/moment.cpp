// SPDX-License-Identifier: Apache-2.0
#include "field/moment.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace bccsplat {

std::array<float, 2> MomentPlan::range() const {
  std::array<float, 2> range{};
  const float most = largest_weight();
  for (const Part& p : parts_)
    range = {std::min(range[0], most * p.range[0]), std::max(range[1], most * p.range[1])};
  return range;
}

float MomentPlan::largest_weight() const {
  constexpr double steps = 64, rounding = 1e-4; // of sums of floats
  std::array<double, 2> sum{};
  for (const Part& p : parts_) sum[static_cast<size_t>(p.coset)] += static_cast<double>(p.weight);
  return static_cast<float>(std::ceil((std::max(sum[0], sum[1]) - rounding) * steps) / steps);
}

int64_t MomentPlan::kept_sites() const {
  int64_t count = 0;
  for (int coset = 0; coset < 2; ++coset) {
    std::vector<const Part*> parts;
    for (const Part& p : parts_)
      if (p.coset == coset) parts.push_back(&p);
    for (size_t slot = 0; !parts.empty() && slot < parts.front()->of.brick_slots(); ++slot) {
      BrickMask any{};
      for (const Part* p : parts) {
        if (!p->of.there(slot)) continue;
        const BrickMask* const kept = p->of.kept(slot);
        for (size_t row = 0; row < any.size(); ++row)
          any[row] = static_cast<uint16_t>(any[row] | (kept ? (*kept)[row] : 0xffff));
      }
      for (const uint16_t row : any) count += std::popcount(row);
    }
  }
  return count;
}

const MergedCosets& MomentPlan::merged(const Context& context) const {
  if (is_merged()) return cosets_;
  MergedCosets made = merge_(parts_, context); // no lock is held by who waits for others
  const std::scoped_lock lock(mutex_);
  if (!is_merged()) {
    cosets_ = std::move(made);
    there_.store(true, std::memory_order_release);
  }
  return cosets_;
}

const MergedCosets& MomentPlan::merged() const {
  if (is_merged()) return cosets_;
  Tasks tasks(1);
  MemoryBudget memory;
  Progress progress;
  return merged({tasks, memory, progress});
}

uint64_t MomentPlan::bytes() const {
  if (is_merged()) return cosets_[0].bytes() + cosets_[1].bytes();
  uint64_t bricks = 0;
  for (int coset = 0; coset < 2; ++coset) {
    std::vector<bool> there;
    for (const Part& p : parts_) {
      if (p.coset != coset) continue;
      there.resize(p.of.brick_slots());
      for (size_t slot = 0; slot < there.size(); ++slot) there[slot] = there[slot] || p.of.there(slot);
    }
    bricks += static_cast<uint64_t>(std::count(there.begin(), there.end(), true));
  }
  return bricks * sizeof(Brick);
}

int64_t SliceCosets::kept_sites() const {
  if (moment_ && !moment_->is_merged()) return moment_->kept_sites();
  return all()[0].kept_sites() + all()[1].kept_sites();
}

uint64_t SliceCosets::bytes() const { return moment_ ? moment_->bytes() : own_[0].bytes() + own_[1].bytes(); }

} // namespace bccsplat
