// SPDX-License-Identifier: Apache-2.0
// Lines of an axis are gathered, up to 64 side by side, lifted, and put back with their coarse half first.
#include "formats/bcc4/wavelet/halvings.h"

#include <algorithm>
#include <vector>

namespace bccsplat {
namespace {

// Predict, update, predict, update (Daubechies and Sweldens 1998), and the scale of the coarse half.
constexpr std::array<float, 4> lifting{-1.586134342F, -0.05298011854F, 0.8829110762F, 0.4435068522F};
constexpr double exact_scale = 1.149604398;
constexpr auto coarse_scale = static_cast<float>(exact_scale),
               fine_scale = static_cast<float>(1 / exact_scale);

// Rows of `width` values that lie side by side are transformed at once: value i of a row is at i * width.
struct Rows {
  float* data;
  int count, width;
  [[nodiscard]] float* row(int i) const { return data + static_cast<size_t>(i) * width; }
};

void add_neighbours(float* to, const float* a, const float* b, float weight, int width) {
  for (int i = 0; i < width; ++i) to[i] += weight * (a[i] + b[i]);
}

// Adds to each row of one parity its two neighbours, mirrored at the ends.
void lift(const Rows& rows, int parity, float weight) {
  for (int i = parity; i < rows.count; i += 2) {
    const int before = i > 0 ? i - 1 : 1, after = i + 1 < rows.count ? i + 1 : rows.count - 2;
    add_neighbours(rows.row(i), rows.row(before), rows.row(after), weight, rows.width);
  }
}

void scale(const Rows& rows, int parity, float factor) {
  for (int i = parity; i < rows.count; i += 2)
    for (int x = 0; x < rows.width; ++x) rows.row(i)[x] *= factor;
}

void forward(const Rows& rows) {
  for (int step = 0; step < 4; ++step) lift(rows, 1 - step % 2, lifting[step]);
  scale(rows, 0, coarse_scale);
  scale(rows, 1, fine_scale);
}

void backward(const Rows& rows) {
  scale(rows, 0, fine_scale);
  scale(rows, 1, coarse_scale);
  for (int step = 3; step >= 0; --step) lift(rows, 1 - step % 2, -lifting[step]);
}

// Samples of a frame along one axis, for some of its lines.
struct Lines {
  float* data;
  size_t stride, across; // between samples of a line, between lines
  int count, width;
};

int row_of(int sample, int count, bool split) {
  return split ? (sample % 2 == 0 ? sample / 2 : (count + 1) / 2 + sample / 2) : sample;
}

void gather(const Lines& from, const Rows& to, bool split) {
  for (int i = 0; i < from.count; ++i) {
    const float* const line = from.data + row_of(i, from.count, split) * from.stride;
    for (int x = 0; x < from.width; ++x) to.row(i)[x] = line[x * from.across];
  }
}

void scatter(const Rows& from, const Lines& to, bool split) {
  for (int i = 0; i < to.count; ++i) {
    float* const line = to.data + row_of(i, to.count, split) * to.stride;
    for (int x = 0; x < to.width; ++x) line[x * to.across] = from.row(i)[x];
  }
}

// Lines that are transformed at once: their samples stay in the cache.
constexpr int most_lines = 64;

void transform(Lines lines, bool inverse, std::vector<float>& scratch) {
  scratch.resize(static_cast<size_t>(lines.count) * most_lines);
  const int all = lines.width;
  float* const first = lines.data;
  for (int x = 0; x < all; x += most_lines) {
    lines.width = std::min(most_lines, all - x);
    lines.data = first + x * lines.across;
    const Rows rows{scratch.data(), lines.count, lines.width};
    gather(lines, rows, inverse);
    inverse ? backward(rows) : forward(rows);
    scatter(rows, lines, !inverse);
  }
}

void transform_axis(const Halvings& shape, int level, int axis, bool inverse, float* frame,
                    std::vector<float>& scratch) {
  const int nx = shape.kept(0, level - 1), ny = shape.kept(1, level - 1), nz = shape.kept(2, level - 1);
  const size_t row = shape.size[0], plane = row * shape.size[1];
  if (axis == 0)
    for (int z = 0; z < nz; ++z) transform({frame + z * plane, 1, row, nx, ny}, inverse, scratch);
  if (axis == 1)
    for (int z = 0; z < nz; ++z) transform({frame + z * plane, row, 1, ny, nx}, inverse, scratch);
  if (axis == 2)
    for (int y = 0; y < ny; ++y) transform({frame + y * row, plane, 1, nz, nx}, inverse, scratch);
}

bool is_split(const Halvings& shape, int level, int axis) {
  return shape.halves(axis, level) && shape.kept(axis, level - 1) > 1;
}

} // namespace

int Halvings::levels() const { return std::max({times[0], times[1], times[2]}); }

int Halvings::kept(int axis, int level) const {
  const int by = std::min(level, times[axis]);
  return (size[axis] + (1 << by) - 1) >> by;
}

void analyse(const Halvings& shape, std::span<float> frame) {
  std::vector<float> scratch;
  for (int level = 1; level <= shape.levels(); ++level)
    for (int axis = 0; axis < 3; ++axis)
      if (is_split(shape, level, axis)) transform_axis(shape, level, axis, false, frame.data(), scratch);
}

void synthesise(const Halvings& shape, std::span<float> frame) {
  std::vector<float> scratch;
  for (int level = shape.levels(); level >= 1; --level)
    for (int axis = 2; axis >= 0; --axis)
      if (is_split(shape, level, axis)) transform_axis(shape, level, axis, true, frame.data(), scratch);
}

} // namespace bccsplat
