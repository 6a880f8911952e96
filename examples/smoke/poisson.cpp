// SPDX-License-Identifier: Apache-2.0
// Geometric multigrid in V-cycles: red-black Gauss-Seidel on every level, residuals averaged down,
// corrections interpolated up.
#include "smoke/poisson.h"

#include <algorithm>

#include "smoke/parallel.h"

namespace smoke {

namespace {

// The rows next to row (j, k); a row beyond the wall is all zero and does not count.
struct Rows {
  const float *below, *above, *behind, *before;
  int count;
};

Rows rows(const Grid& p, int n, int j, int k, const std::vector<float>& zero) {
  const float* none = zero.data();
  return {j > 0 ? &p(0, j - 1, k) : none, j < n - 1 ? &p(0, j + 1, k) : none, k > 0 ? &p(0, j, k - 1) : none,
          k < n - 1 ? &p(0, j, k + 1) : none, (j > 0) + (j < n - 1) + (k > 0) + (k < n - 1)};
}

struct Neighbours {
  float sum;
  int count;
};

Neighbours neighbours(const Rows& r, const float* row, int n, int i) {
  float sum = (r.below[i] + r.above[i]) + (r.behind[i] + r.before[i]);
  if (i > 0) sum += row[i - 1];
  if (i < n - 1) sum += row[i + 1];
  return {sum, r.count + (i > 0) + (i < n - 1)};
}

} // namespace

Poisson::Poisson(int n, int threads) : threads_(threads) {
  float h2 = 1;
  for (int size = n;; size /= 2, h2 *= 4) {
    levels_.push_back({size, h2, Grid(size, size, size), Grid(size, size, size), Grid(size, size, size)});
    if (size % 2 != 0 || size <= 4) break;
  }
}

void Poisson::solve(int v_cycles) {
  for (int i = 0; i < v_cycles; ++i) cycle(0);
}

void Poisson::cycle(size_t at) {
  Level& level = levels_[at];
  if (at + 1 == levels_.size()) {
    relax(level, 8 * level.n);
    return;
  }
  relax(level, 2);
  compute_residual(level);
  Level& coarse = levels_[at + 1];
  restrict_to(level, coarse);
  std::fill(coarse.p.samples.begin(), coarse.p.samples.end(), 0.0f);
  cycle(at + 1);
  correct_from(coarse, level);
  relax(level, 2);
}

// Red-black Gauss-Seidel: cells of one colour depend on the other colour only, so any order gives the same
// result.
void Poisson::relax(Level& level, int sweeps) {
  const int n = level.n;
  const std::vector<float> zero(static_cast<size_t>(n));
  const float inverse[] = {0, 1, 1 / 2.0f, 1 / 3.0f, 1 / 4.0f, 1 / 5.0f, 1 / 6.0f};
  for (int half = 0; half < 2 * sweeps; ++half) {
    parallel_ranges(n < 16 ? 1 : threads_, n, [&](int begin, int end) {
      for (int k = begin; k < end; ++k)
        for (int j = 0; j < n; ++j) {
          const Rows around = rows(level.p, n, j, k, zero);
          const float* rhs = &level.rhs(0, j, k);
          float* p = &level.p(0, j, k);
          for (int i = (half + j + k) % 2; i < n; i += 2) {
            const Neighbours nb = neighbours(around, p, n, i);
            p[i] = (nb.sum - level.h2 * rhs[i]) * inverse[nb.count];
          }
        }
    });
  }
}

void Poisson::compute_residual(Level& level) {
  const int n = level.n;
  const std::vector<float> zero(static_cast<size_t>(n));
  parallel_ranges(n < 16 ? 1 : threads_, n, [&](int begin, int end) {
    for (int k = begin; k < end; ++k)
      for (int j = 0; j < n; ++j) {
        const Rows around = rows(level.p, n, j, k, zero);
        const float* p = &level.p(0, j, k);
        for (int i = 0; i < n; ++i) {
          const Neighbours nb = neighbours(around, p, n, i);
          const float laplace = (nb.sum - static_cast<float>(nb.count) * p[i]) / level.h2;
          level.residual(i, j, k) = level.rhs(i, j, k) - laplace;
        }
      }
  });
}

// Each coarse cell gets the mean of its eight children.
void Poisson::restrict_to(const Level& fine, Level& coarse) {
  const int n = coarse.n;
  parallel_ranges(n < 16 ? 1 : threads_, n, [&](int begin, int end) {
    for (int k = begin; k < end; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          float sum = 0;
          for (int c = 0; c < 8; ++c)
            sum += fine.residual(2 * i + (c & 1), 2 * j + (c >> 1 & 1), 2 * k + (c >> 2));
          coarse.rhs(i, j, k) = sum / 8;
        }
  });
}

// Corrections are trilinear between coarse centres: 3/4 of the nearer and 1/4 of the farther along each axis.
void Poisson::correct_from(const Level& coarse, Level& fine) {
  const int n = fine.n;
  parallel_ranges(n < 16 ? 1 : threads_, n, [&](int begin, int end) {
    const auto place = [](int i) { return (static_cast<float>(i) - 0.5f) / 2; };
    for (int k = begin; k < end; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          fine.p(i, j, k) += interpolate(coarse.p, Vec3{place(i), place(j), place(k)});
  });
}

} // namespace smoke
