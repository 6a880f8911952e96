// SPDX-License-Identifier: Apache-2.0
// Fills missing samples by a pyramid of means, relaxed on every level.
#include "fit/resample/fill.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "fit/axis/filter.h"

namespace bccsplat {
namespace {

using Dims = std::array<int64_t, 3>;

// Steps towards the mean of the neighbours on each level: more are smoother, each passes once over what is
// missing.
constexpr int relaxations = 12;
// With a bounded reach: cells that data go on for at the coarsest level, and fewer steps, each of which is a
// cell of reach (tests/bench/notes/blocks.md).
constexpr int grown_cells = 3;
int bounded_relaxations(int level, int coarsest) {
  if (level == coarsest) return 1;
  return level == 0 ? 4 : level == 1 ? 2 : 1;
}

size_t volume(const Dims& n) { return static_cast<size_t>(n[0]) * n[1] * n[2]; }
size_t at(const Dims& n, int64_t x, int64_t y, int64_t z) { return (z * n[1] + y) * n[0] + x; }

struct Level {
  Dims dims;
  std::vector<float> value;
  std::vector<uint8_t> missing;
};

Level coarser(std::span<const float> value, std::span<const uint8_t> missing, const Dims& n) {
  Level c;
  for (size_t a = 0; a < 3; ++a) c.dims[a] = (n[a] + 1) / 2;
  c.value.resize(volume(c.dims));
  c.missing.resize(c.value.size());
  for (int64_t z = 0; z < c.dims[2]; ++z)
    for (int64_t y = 0; y < c.dims[1]; ++y)
      for (int64_t x = 0; x < c.dims[0]; ++x) {
        double sum = 0;
        int known = 0;
        for (int64_t k = 2 * z; k < std::min(2 * z + 2, n[2]); ++k)
          for (int64_t j = 2 * y; j < std::min(2 * y + 2, n[1]); ++j)
            for (int64_t i = 2 * x; i < std::min(2 * x + 2, n[0]); ++i)
              if (!missing[at(n, i, j, k)]) {
                sum += value[at(n, i, j, k)];
                ++known;
              }
        c.value[at(c.dims, x, y, z)] = known ? static_cast<float>(sum / known) : 0;
        c.missing[at(c.dims, x, y, z)] = known == 0;
      }
  return c;
}

// A full coarse level, linearly at the centre of fine cell (x, y, z).
float interpolate(const Level& c, const Dims& fine, const AxisFlags& turning) {
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Dims p;
    float weight = 1;
    for (size_t a = 0; a < 3; ++a) {
      const bool far = corner >> a & 1; // the coarse neighbour on the side of the fine cell
      const int64_t side = fine[a] % 2 == 0 ? -1 : 1;
      p[a] = fine[a] / 2 + (far ? side : 0);
      p[a] = turning[a] ? end_index(p[a], c.dims[a], true) : std::clamp<int64_t>(p[a], 0, c.dims[a] - 1);
      weight *= far ? 0.25f : 0.75f;
    }
    sum += weight * c.value[at(c.dims, p[0], p[1], p[2])];
  }
  return sum;
}

// Each missing sample becomes the mean of its neighbours inside the array; all at once, so the order does not
// matter.
void relax(std::span<float> value, const std::vector<size_t>& missing, const Dims& n,
           const AxisFlags& turning, const Context& context, int steps) {
  constexpr size_t part = 1 << 15;
  std::vector<float> next(missing.size());
  const auto parts = (missing.size() + part - 1) / part;
  const auto for_parts = [&](const auto& body) {
    context.tasks.parallel_for(parts, [&](uint64_t p) {
      context.progress.check();
      for (size_t m = p * part; m < std::min(missing.size(), (p + 1) * part); ++m) body(m);
    });
  };
  const auto row = static_cast<size_t>(n[0]), plane = row * n[1];
  for (int r = 0; r < steps; ++r) {
    for_parts([&](size_t m) {
      const size_t i = missing[m];
      const Dims p{static_cast<int64_t>(i % row), static_cast<int64_t>(i / row % static_cast<size_t>(n[1])),
                   static_cast<int64_t>(i / plane)};
      const Dims stride{1, n[0], n[0] * n[1]};
      float sum = 0;
      int count = 0;
      for (size_t a = 0; a < 3; ++a)
        for (const int64_t q : {p[a] - 1, p[a] + 1}) {
          if (!turning[a] && (q < 0 || q >= n[a])) continue;
          const int64_t by = end_index(q, n[a], true) - p[a];
          sum += value[static_cast<int64_t>(i) + by * stride[a]], ++count;
        }
      next[m] = count ? sum / static_cast<float>(count) : value[i];
    });
    for_parts([&](size_t m) { value[missing[m]] = next[m]; });
  }
}

std::vector<size_t> missing_ones(std::span<const uint8_t> missing) {
  std::vector<size_t> list;
  for (size_t i = 0; i < missing.size(); ++i)
    if (missing[i]) list.push_back(i);
  return list;
}

// Calls body with the place of each cell around one, itself among them.
template<class Body>
void for_neighbours(const Dims& p, const Dims& n, const AxisFlags& turning, const Body& body) {
  for (int64_t z = p[2] - 1; z <= p[2] + 1; ++z)
    for (int64_t y = p[1] - 1; y <= p[1] + 1; ++y)
      for (int64_t x = p[0] - 1; x <= p[0] + 1; ++x) {
        Dims q{x, y, z};
        bool inside = true;
        for (size_t a = 0; a < 3; ++a) {
          inside = inside && (turning[a] || (q[a] >= 0 && q[a] < n[a]));
          q[a] = end_index(q[a], n[a], true);
        }
        if (inside) body(at(n, q[0], q[1], q[2]));
      }
}

// Gives cells beside known ones the mean of those, again and again; those that are left are air.
void grow(std::span<float> value, std::vector<uint8_t> missing, std::vector<size_t> list, const Dims& n,
          const AxisFlags& turning) {
  for (const size_t i : list) value[i] = 0;
  for (int step = 0; step < grown_cells; ++step) {
    std::vector<std::pair<size_t, float>> found;
    std::erase_if(list, [&](size_t i) {
      const auto row = static_cast<size_t>(n[0]), plane = row * n[1];
      double sum = 0;
      int known = 0;
      for_neighbours({static_cast<int64_t>(i % row), static_cast<int64_t>(i % plane / row),
                      static_cast<int64_t>(i / plane)},
                     n, turning, [&](size_t k) {
                       if (!missing[k]) sum += value[k], ++known;
                     });
      if (known > 0) found.emplace_back(i, static_cast<float>(sum / known));
      return known > 0;
    });
    for (const auto& [i, v] : found) value[i] = v, missing[i] = 0;
  }
}

// level: 0 of the samples. coarsest: the last one; 0: it is not bounded.
void fill_level(std::span<float> values, std::span<const uint8_t> missing, const Dims& dims,
                const Context& context, const AxisFlags& turning, int level, int coarsest) {
  const std::vector<size_t> list = missing_ones(missing);
  if (list.empty()) return;
  if (list.size() == missing.size()) {
    std::fill(values.begin(), values.end(), 0.0f);
    return;
  }
  const bool bounded = coarsest > 0;
  if (bounded && level == coarsest) {
    grow(values, {missing.begin(), missing.end()}, list, dims, turning);
  } else {
    Level coarse = coarser(values, missing, dims);
    fill_level(coarse.value, coarse.missing, coarse.dims, context, turning, level + 1, coarsest);
    const auto row = static_cast<size_t>(dims[0]), plane = row * dims[1];
    for (const size_t i : list)
      values[i] = interpolate(coarse,
                              {static_cast<int64_t>(i % row), static_cast<int64_t>(i % plane / row),
                               static_cast<int64_t>(i / plane)},
                              turning);
  }
  relax(values, list, dims, turning, context, bounded ? bounded_relaxations(level, coarsest) : relaxations);
}

} // namespace

FillReach FillReach::of(double samples) {
  FillReach reach{2}; // one halving is not enough beside data
  while (static_cast<double>(grown_cells * reach.cell()) < samples) ++reach.halvings;
  return reach;
}

int64_t FillReach::samples() const {
  if (!bounded()) return 0;
  int64_t cells = grown_cells + bounded_relaxations(halvings, halvings);
  // Two cells of the coarser level along each axis, and each step one further.
  for (int level = halvings; level-- > 0;) cells = 2 * cells + 2 + bounded_relaxations(level, halvings);
  return cells;
}

void fill_missing(std::span<float> values, std::span<const uint8_t> missing, const Dims& dims,
                  const Context& context, const AxisFlags& turning, const FillReach& reach) {
  fill_level(values, missing, dims, context, turning, 0, reach.halvings);
}

} // namespace bccsplat
