// SPDX-License-Identifier: Apache-2.0
// Geometric multigrid for the pressure of a closed cube.
#pragma once

#include <vector>

#include "smoke/grid.h"

namespace smoke {

// Solves laplace(p) = rhs on n^3 cell centres, unit spacing, no flow through the walls (zero normal
// gradient). The solution is unique up to a constant and exists because the divergence of a closed box sums
// to zero.
class Poisson {
 public:
  Poisson(int n, int threads);

  Grid& rhs() { return levels_.front().rhs; }
  // The pressure is kept from call to call, as the start of the next solution.
  Grid& pressure() { return levels_.front().p; }
  void solve(int v_cycles);

 private:
  struct Level {
    int n;
    float h2; // squared cell size in cells of the finest level
    Grid p, rhs, residual;
  };
  void cycle(size_t level);
  void relax(Level& level, int sweeps);
  void compute_residual(Level& level);
  void restrict_to(const Level& fine, Level& coarse);
  void correct_from(const Level& coarse, Level& fine);

  int threads_;
  std::vector<Level> levels_;
};

} // namespace smoke
