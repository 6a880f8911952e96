// SPDX-License-Identifier: Apache-2.0
// The sheets of one object are taken from its SheetSource. Those of several are summed up in planes that stay
// from tile to tile: what a plane held before is cleared where the new sum does not cover it.
#include "splat/tile/drawn_sheets.h"

#include <algorithm>
#include <utility>

#include "base/grid.h"

namespace bccsplat {

DrawnSheets::DrawnSheets(const DrawnSources& sources, std::span<const SheetShare> shares,
                         const ClassTable& table, float base, bool base_seen, float* mixed)
    : sources_(sources), shares_(shares), table_(table), base_(base), base_seen_(base_seen),
      mixed_(shares.size() > 1 ? mixed : nullptr),
      // The planes may hold anything of the tile before.
      gradients_touched_{0, 0, sources.plane_pitch, sources.height + 2 * sources.border} {
  touched_.slot.fill(gradients_touched_);
}

float* DrawnSheets::mixed_plane(int64_t k, size_t quantity) const {
  const size_t n = quantity == 0 ? finished_slot(k) : finished_sheets + quantity - 1;
  return mixed_ + n * sources_.object.front().plane_floats() + plane_margin;
}

// Makes the weighted sum of one quantity of sheet k, in a plane that holds nothing outside of `before`.
std::array<float, 2> DrawnSheets::mix_plane(int64_t k, size_t quantity, const PixelRect& before) {
  const PixelRect& rect = touched_[k];
  const int pitch = sources_.plane_pitch;
  const std::ptrdiff_t first = plane_offset(rect.x0, rect.y0, pitch);
  from_.clear(), weights_.clear();
  for (const SheetShare& s : shares_)
    if (const SheetSource& source = sources_.object[s.source]; source.filled(k)) {
      from_.push_back(source.plane(k, quantity) - sources_.border_floats() + first);
      weights_.push_back(s.weight);
    }
  float* const out = mixed_plane(k, quantity);
  clear_around(before, rect, out, pitch);
  return sources_.loops->mix({from_, weights_, out + first, rect.x1 - rect.x0, rect.y1 - rect.y0, pitch});
}

void DrawnSheets::mix_values(int64_t k) {
  filled_[k] = false, range_[k] = {0, 0};
  PixelRect touched;
  for (const SheetShare& s : shares_) {
    const SheetSource& source = sources_.object[s.source];
    filled_[k] = filled_[k] || source.filled(k);
    if (const PixelRect r = source.plane_touched(k); !r.empty()) touched.include(r);
  }
  if (!filled_[k]) return;
  if (touched.empty()) touched = {0, 0, 0, 0};
  const PixelRect before = std::exchange(touched_[k], touched);
  range_[k] = mix_plane(k, 0, before);
}

void DrawnSheets::mix(int64_t first, int64_t last) {
  if (!mixed_) return;
  for (int64_t sheet = first; sheet <= last; ++sheet) mix_values(sheet);
}

void DrawnSheets::mix_gradients(int64_t k) {
  if (!mixed_ || !sources_.gradients || !filled_[k]) return;
  for (size_t q = 1; q <= gradient_planes; ++q) (void)mix_plane(k, q, gradients_touched_);
  gradients_touched_ = touched_[k];
}

const float* DrawnSheets::plane(int64_t k, size_t quantity) const {
  if (!mixed_) return own().plane(k, quantity);
  if (!filled_[k]) return sources_.object.front().zero_plane();
  return mixed_plane(k, quantity) + sources_.border_floats();
}

// The sheets that the segments of sheet k are classified by.
std::array<int64_t, 2> DrawnSheets::looked_at(int64_t k) const {
  const int halfway = table_.integrals.empty() ? 0 : sources_.halfway;
  return {std::max(k - halfway, sources_.first_sheet), k + halfway};
}

PixelRect DrawnSheets::touched(int64_t k) const {
  PixelRect rect{};
  const int border = sources_.border;
  const auto [first, last] = looked_at(k);
  for (int64_t sheet = first; sheet <= last; ++sheet) {
    if (!mixed_) {
      rect.include(own().touched(sheet));
    } else if (filled_[sheet]) {
      const PixelRect& r = touched_[sheet];
      rect.include({r.x0 - border, r.y0 - border, r.x1 - border, r.y1 - border});
    }
  }
  return rect;
}

bool DrawnSheets::seen(int64_t k) const {
  if (base_seen_) return true;
  const auto [first, last] = looked_at(k);
  bool filled = false;
  std::array<float, 2> range{0, 0};
  for (int64_t sheet = first; sheet <= last; ++sheet) {
    if (!mixed_) {
      filled = filled || own().filled(sheet);
    } else if (filled_[sheet]) {
      filled = true;
      range = {std::min(range[0], range_[sheet][0]), std::max(range[1], range_[sheet][1])};
    }
  }
  if (!mixed_ || !filled) return filled;
  // Between sheets the cubic reaches beyond its samples by up to an eighth of their range.
  const float beyond = first < last ? 0.125f * (range[1] - range[0]) : 0.0f;
  return table_.crossed(base_ + (range[0] - beyond), base_ + (range[1] + beyond));
}

} // namespace bccsplat
