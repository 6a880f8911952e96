// SPDX-License-Identifier: Apache-2.0
// Incompressible smoke in a closed cube of edge 1 ("stable fluids": Stam 1999; staggered velocities;
// MacCormack advection: Selle et al. 2008; vorticity confinement: Fedkiw, Stam, Jensen 2001). y is up.
// Lengths are in cube edges, times in seconds.
#pragma once

#include <span>

#include "smoke/grid.h"
#include "smoke/poisson.h"

namespace smoke {

// A soft ball that keeps its inside at `density` and its air at `velocity` (cube edges per second).
struct Source {
  Vec3 centre;
  float radius;
  Vec3 velocity;
  float density;
};

struct Physics {
  float buoyancy = 0.8f;    // upward acceleration of density 1, edges / s^2
  float confinement = 0.5f; // strength of vorticity confinement, 1: as strong as the vorticity itself
  float decay = 0.15f;      // fraction of the density lost per second
  float fade = 0.02f;       // density lost per second whatever its value, so that smoke ends somewhere
  float cooling = 1.2f;     // fraction of the heat lost per second
};

class Solver {
 public:
  // There are n cells per axis; n must be even. heat: whether heat is carried along, which moves nothing.
  Solver(int n, int threads, bool heat = false);

  [[nodiscard]] const Grid& density() const { return density_; }
  // 1 in a source that blows, 0 far from any.
  [[nodiscard]] const Grid& heat() const { return heat_; }
  void step(float seconds, std::span<const Source> sources, const Physics& physics);
  // Returns the largest divergence of the velocity times the cell size, edges / s.
  [[nodiscard]] float divergence();

 private:
  void add_sources(std::span<const Source> sources, float seconds);
  void add_forces(float seconds, const Physics& physics);
  void project();
  void advect(float seconds);
  void advect_one(const Grid& from, Grid& to, Vec3 offset, float cells_per_speed);
  [[nodiscard]] Vec3 velocity_at(Vec3 cells) const;

  int n_, threads_;
  bool has_heat_;
  // Cell (i, j, k) has its centre at (i + 1/2, j + 1/2, k + 1/2) cells; u, v, w are on the faces across x, y,
  // z.
  Grid density_, u_, v_, w_;
  Grid next_density_, next_u_, next_v_, next_w_;
  Grid heat_, next_heat_; // at the centres; empty without
  Grid curl_size_;
  std::vector<Vec3> curl_;
  std::vector<Vec3>
      origin_; // where the air at each sample came from, sample indices; before that, accelerations
  std::vector<float> corrected_;
  Poisson poisson_;
};

} // namespace smoke
