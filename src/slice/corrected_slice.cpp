// SPDX-License-Identifier: Apache-2.0
// Puts the corrections of a file into moments: those of the frames around.
#include "slice/corrected_slice.h"

#include <algorithm>
#include <cmath>

#include "field/corrections.h"

namespace bccsplat {
namespace {

// Adds a value of a source sample to a list; one on the first plane of a periodic axis is that of its end,
// too.
void push_images(const Lattice4& lattice, GridValue value, std::vector<GridValue>& list) {
  const Int3 at = value.at;
  for (size_t corner = 0; corner < 8; ++corner) {
    bool is_image = true;
    for (size_t a = 0; a < 3; ++a) {
      const bool far = corner >> a & 1;
      is_image = is_image && (!far || (lattice.turns(a) && at[a] == 0));
      value.at[a] = far ? static_cast<int32_t>(lattice.dims[a]) : at[a];
    }
    if (is_image) list.push_back(value);
  }
}

} // namespace

void set_corrections(Slice& slice, SliceCorrections&& made) {
  if (made.empty()) return;
  const auto [low, high] = made.add.range();
  slice.bounds[0] += low, slice.bounds[1] += high;
  made.set.each([&](const Int3&, float v) {
    slice.bounds = {std::min(slice.bounds[0], static_cast<double>(v)),
                    std::max(slice.bounds[1], static_cast<double>(v))};
  });
  slice.corrections = std::make_shared<const SliceCorrections>(std::move(made));
}

void correct_time_slice(Slice& slice, const Coefficients& coefficients, std::array<double, 2> frames,
                        const Corrections::Box& box, ThicknessKind kind) {
  const Corrections* fix = coefficients.corrections();
  if (!fix) return;
  const FallOff fall(fix->shape());
  const int64_t count = fix->samples()[3];
  if (count == 1) frames = {};
  const double t0 = frames[0], t1 = frames[1];
  std::vector<GridValue> add, set;
  const Lattice4& lattice = coefficients.source().lattice();
  auto first = static_cast<int64_t>(std::floor(t0)), last = static_cast<int64_t>(std::ceil(t1));
  if (!lattice.periodic) first = std::max<int64_t>(0, first), last = std::min(count - 1, last);
  for (int64_t counted = first; counted <= last; ++counted) {
    const auto at = static_cast<double>(counted);
    const int64_t f = lattice.turned_frame(counted);
    double weight = fall.value(t0 - at);
    if (t0 < t1) weight = fall.integral(t0 - at, t1 - at) / (kind == ThicknessKind::sum ? 1 : t1 - t0);
    const auto w = static_cast<float>(weight);
    if (w > 0)
      fix->each(
          f,
          [&](const Int3& p, float value) {
            push_images(lattice, {p, value * w}, add);
          },
          box);
    if (t0 == t1 && std::fabs(t0 - at) < touches_end)
      fix->each_set(f, [&](const Int3& p, float value) { push_images(lattice, {p, value}, set); });
  }
  set_corrections(slice, {{}, fix->shape(), SparseGrid(std::move(add)), SparseGrid(std::move(set))});
}

} // namespace bccsplat
