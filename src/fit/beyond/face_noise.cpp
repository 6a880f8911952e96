// SPDX-License-Identifier: Apache-2.0
#include "fit/beyond/face_noise.h"

#include <algorithm>
#include <vector>

#include "fit/beyond/noise_trial.h"

namespace bccsplat {
namespace {

constexpr int64_t rows_tried = 96; // along an axis of a face, at most; larger faces are looked at in steps

// Rows across `axis` at one end, for some positions along the two others.
void add_rows(const Frame& frame, size_t axis, bool far, NoiseTrial& trial) {
  const std::array<int64_t, 3>& n = frame.dims();
  const size_t along = axis == 0 ? 1 : 0, other = 3 - axis - along;
  const auto step = [&](size_t a) { return (n[a] + rows_tried - 1) / rows_tried; };
  Region region;
  for (size_t a = 0; a < 3; ++a) region.begin[a] = 0, region.end[a] = n[a];
  region.begin[axis] = far ? n[axis] - trial.depth() : 0;
  region.end[axis] = region.begin[axis] + trial.depth();
  std::vector<float> box, row(static_cast<size_t>(trial.depth()));
  for (int64_t o = 0; o < n[other]; o += step(other)) {
    region.begin[other] = o, region.end[other] = o + 1;
    const std::array<int64_t, 3> stride{1, region.length(0), region.length(0) * region.length(1)};
    box.resize(region.samples());
    frame.read(frame.boxes_in(region), region, box.data(), stride[1], stride[2]);
    for (int64_t i = 0; i < n[along]; i += step(along)) {
      for (int64_t k = 0; k < trial.depth(); ++k)
        row[far ? trial.depth() - 1 - k : k] = box[i * stride[along] + k * stride[axis]];
      trial.add(row);
    }
  }
}

} // namespace

FaceLevels choose_face_levels(const Frame& frame, const Lattice4& lattice) {
  FaceLevels levels = usual_face_levels;
  for (size_t a = 0; a < 3; ++a) {
    if (lattice.before[a] + lattice.behind[a] == 0 || frame.dims()[a] < 3) continue;
    NoiseTrial trial(frame.dims()[a], std::max(1.0, lattice.space_step[a] / lattice.space.plane_distance()));
    for (const bool far : {false, true}) add_rows(frame, a, far, trial);
    levels[a] = trial.best();
  }
  return levels;
}

} // namespace bccsplat
