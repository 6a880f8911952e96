// SPDX-License-Identifier: Apache-2.0
// The reference form of pre-integrated classification; sheet_classify-inl.h has the fast one.
#include "shade/value_integrals.h"

#include "shade/absorption.h"
#include "shade/class_table.h"

namespace bccsplat {

HalfClass classify_half(const ClassTable& table, float e0, float e1, float length) {
  const ValueIntegrals& t = table.integrals;
  HalfClass out;
  if (!(length > 0)) return out;
  const float span = e1 - e0;
  if (std::fabs(span) < 1) { // no more than the table tells
    const float e = 0.5f * (e0 + e1);
    const float at = std::clamp(e, 0.0f, static_cast<float>(table.size() - 1));
    const auto& [red, green, blue, extinction] = table.entry[static_cast<size_t>(std::nearbyint(at))];
    return {{red, green, blue}, absorbed(extinction * length), extinction * length, e};
  }
  const int j0 = t.below(e0), j1 = t.below(e1);
  const float f0 = e0 - ValueIntegrals::base(j0), f1 = e1 - ValueIntegrals::base(j1);
  const auto* const p0 = t.part.data() + size_t{3} * j0;
  const auto* const p1 = t.part.data() + size_t{3} * j1;
  std::array<float, 4> sum;
  for (size_t c = 0; c < 4; ++c)
    sum[c] = (p1[0][c] - p0[0][c]) + ((p1[1][c] - p0[1][c]) + (f1 * p1[2][c] - f0 * p0[2][c]));
  const float mean = sum[3] / span;
  if (!(mean > 0)) return out;
  for (size_t c = 0; c < 3; ++c) out.color[c] = std::max(sum[c] / sum[3], 0.0f);
  out.depth = mean * length, out.absorbed = absorbed(out.depth);
  const auto &m0 = t.moment[j0], &m1 = t.moment[j1];
  const float inside = f1 * (ValueIntegrals::base(j1) + 0.5f * f1) * p1[2][3] -
                       f0 * (ValueIntegrals::base(j0) + 0.5f * f0) * p0[2][3];
  const float moment = (m1[0] - m0[0]) + ((m1[1] - m0[1]) + inside);
  out.e = std::clamp(moment / sum[3], std::min(e0, e1), std::max(e0, e1));
  return out;
}

SegmentClass classify_segment(const ClassTable& table, const std::array<float, 3>& e,
                              const std::array<float, 2>& length) {
  SegmentClass out;
  if (!table.integrals.visible(std::min({e[0], e[1], e[2]}), std::max({e[0], e[1], e[2]}))) return out;
  const HalfClass a = classify_half(table, e[0], e[1], length[0]),
                  b = classify_half(table, e[1], e[2], length[1]);
  const float behind = (1 - a.absorbed) * b.absorbed;
  out.front = a.absorbed, out.absorbed = a.absorbed + behind, out.depth = a.depth + b.depth;
  if (!(out.absorbed > 0)) return out;
  const float fa = a.absorbed / out.absorbed, fb = behind / out.absorbed;
  for (size_t c = 0; c < 3; ++c) out.color[c] = fa * a.color[c] + fb * b.color[c];
  out.value = table.low + (fa * a.e + fb * b.e) / table.scale;
  return out;
}

} // namespace bccsplat
