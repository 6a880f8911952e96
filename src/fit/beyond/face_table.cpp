// SPDX-License-Identifier: Apache-2.0
#include "fit/beyond/face_table.h"

#include <vector>

#include "fit/axis/site_axis.h"
#include "fit/beyond/against_mirrors.h"
#include "fit/beyond/ends.h"

namespace bccsplat {
namespace {

// Positions of planes outside the first sample of an axis, then outside the last.
constexpr size_t planes_outside = 5;
std::vector<double> outside_positions(const Lattice4& lattice, size_t axis) {
  std::vector<double> positions;
  for (const bool far : {false, true})
    for (size_t k = 0; k < planes_outside; ++k) {
      const double out = static_cast<double>(k) * lattice.space_step[axis];
      positions.push_back(far ? lattice.dims[axis] - 1.0 + out : -out);
    }
  return positions;
}

} // namespace

FilterTable face_table(const Lattice4& lattice, int coset, size_t axis, double widening, double noise) {
  std::vector<double> positions = site_positions(lattice, coset, axis);
  const size_t sites = positions.size();
  for (const double p : outside_positions(lattice, axis)) positions.push_back(p);
  FilterTable table = filter_table(widening, positions);
  EndFrames ends(widening, noise);
  continue_rows(table, lattice.dims[axis], ends);
  const size_t taps = table.taps;
  const auto mend = [&](size_t site, size_t first_outside) {
    for (const auto& [plane, factor] : against_mirrors)
      for (size_t k = 0; k < taps; ++k)
        table.weight[site * taps + k] += factor * table.weight[(first_outside + plane) * taps + k];
  };
  const int32_t last = lattice.space.last[axis];
  for (size_t i = 0; lattice.space.bcc && i < sites; ++i) {
    const int32_t plane = lattice.space.plane(coset, static_cast<int32_t>(i));
    if (lattice.before[axis] == mended_plane && plane == 0) mend(i, sites);
    if (lattice.behind[axis] == mended_plane && plane == last) mend(i, sites + planes_outside);
  }
  table.first.resize(sites), table.weight.resize(sites * taps);
  return table;
}

} // namespace bccsplat
