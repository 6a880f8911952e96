// SPDX-License-Identifier: Apache-2.0
// The transfer function as the sheets use it: a table from value to colour and extinction.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "shade/value_integrals.h"

namespace bccsplat {

// Entry i serves values within half an entry of low + i / scale; values beyond the ends take the end entries.
struct ClassTable {
  float low = 0, scale = 1; // value -> entry: (value - low) * scale
  float unit_distance = 1;  // world length that opacities are meant for
  // red, green, blue (linear, straight) and extinction per world length, -ln(1 - opacity) / unit_distance.
  std::vector<std::array<float, 4>> entry;
  std::vector<uint32_t> visible_before; // entries before i that absorb; one more than entries
  int first_visible = 0, last_visible = -1;
  ValueIntegrals integrals; // where segments are classified by them; empty: by the entries alone

  [[nodiscard]] int size() const { return static_cast<int>(entry.size()); }
  [[nodiscard]] int index(float value) const {
    const float e = std::clamp((value - low) * scale, 0.0f, static_cast<float>(size() - 1));
    return static_cast<int>(std::nearbyint(e));
  }
  // Returns whether any value of [a, b] absorbs (index() never falls as the value rises).
  [[nodiscard]] bool visible(double a, double b) const {
    const size_t i = index(static_cast<float>(a));
    const size_t j = index(static_cast<float>(b));
    return visible_before[j + 1] > visible_before[i];
  }
  // Returns whether a segment whose values lie in [a, b] absorbs: by the entries, and by the integrals where
  // there are any.
  [[nodiscard]] bool crossed(double a, double b) const {
    const auto e = [this](double value) { return (static_cast<float>(value) - low) * scale; };
    return visible(a, b) || (!integrals.empty() && integrals.visible(e(a), e(b)));
  }
};

// Fills visible_before, first_visible and last_visible from the entries.
inline void index_visible(ClassTable& table) {
  table.visible_before.assign(1, 0);
  table.first_visible = table.size();
  table.last_visible = -1;
  for (int i = 0; i < table.size(); ++i) {
    const bool visible = table.entry[i][3] > 0;
    table.visible_before.push_back(table.visible_before.back() + (visible ? 1 : 0));
    if (!visible) continue;
    table.first_visible = std::min(table.first_visible, i);
    table.last_visible = i;
  }
}

} // namespace bccsplat
