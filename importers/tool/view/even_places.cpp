// SPDX-License-Identifier: Apache-2.0
#include "tool/view/even_places.h"

#include <algorithm>
#include <cmath>

namespace bcc4 {

// The volume's affine takes even positions to the world: the way there is as many of its columns.
double even_position(const Volume& volume, uint32_t axis, double index) {
  if (axis_info(volume, axis).count == 0) return index;
  const bccsplat_volume_info v = volume_info(volume);
  std::array<double, 6> places{};
  places[3 + axis] = index;
  check(bccsplat_volume_index_to_world(volume.get(), 2, places.data(), places.data()), "");
  double along = 0, length = 0;
  for (size_t r = 0; r < 3; ++r) {
    const double column = v.affine[4 * r + axis];
    along += column * (places[3 + r] - places[r]), length += column * column;
  }
  return along / length;
}

std::array<double, 5> even_plane(const Volume& volume, const double (&plane)[5]) {
  std::array<double, 5> out{};
  std::copy_n(plane, out.size(), out.begin());
  const auto others = std::count_if(plane, plane + 4, [](double v) { return v != 0; });
  for (uint32_t a = 0; a < 3; ++a)
    if (others == 1 && plane[a] != 0) out[4] = -plane[a] * even_position(volume, a, -plane[4] / plane[a]);
  return out;
}

} // namespace bcc4
