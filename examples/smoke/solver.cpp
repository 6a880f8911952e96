// SPDX-License-Identifier: Apache-2.0
// One step of the smoke solver: sources and forces change the velocity, the projection makes it free of
// divergence, and density and velocity are carried along. solver.h names the papers.
#include "smoke/solver.h"

#include <cmath>
#include <utility>

#include "smoke/parallel.h"

namespace smoke {

namespace {

// Where sample (0, 0, 0) of each grid is, in cells.
constexpr Vec3 centre_offset{0.5f, 0.5f, 0.5f}, u_offset{0, 0.5f, 0.5f}, v_offset{0.5f, 0, 0.5f},
    w_offset{0.5f, 0.5f, 0};

Vec3 place(int i, int j, int k, Vec3 offset) {
  return Vec3{static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)} + offset;
}

Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
float length(Vec3 a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }

// Returns 1 inside 0.6 radii, 0 beyond 1, and smooth values in between.
float inside(const Source& source, Vec3 p) {
  const float s = std::clamp((1 - length(p - source.centre) / source.radius) / 0.4f, 0.0f, 1.0f);
  return s * s * (3 - 2 * s);
}

// Calls body(i, j, k) for every sample of the grid.
template<class Body> void for_each(int threads, const Grid& grid, const Body& body) {
  parallel_ranges(threads, grid.nz, [&](int begin, int end) {
    for (int k = begin; k < end; ++k)
      for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) body(i, j, k);
  });
}

} // namespace

Solver::Solver(int n, int threads, bool heat)
    : n_(n), threads_(threads), has_heat_(heat), density_(n, n, n), u_(n + 1, n, n), v_(n, n + 1, n),
      w_(n, n, n + 1), next_density_(n, n, n), next_u_(n + 1, n, n), next_v_(n, n + 1, n),
      next_w_(n, n, n + 1), heat_(heat ? n : 0, n, n), next_heat_(heat ? n : 0, n, n), curl_size_(n, n, n),
      curl_(density_.samples.size()), origin_(u_.samples.size()), corrected_(u_.samples.size()),
      poisson_(n, threads) {}

void Solver::step(float seconds, std::span<const Source> sources, const Physics& physics) {
  add_sources(sources, seconds);
  add_forces(seconds, physics);
  project();
  advect(seconds);
  const float keep = std::exp(-physics.decay * seconds), lose = physics.fade * seconds;
  const float warm = std::exp(-physics.cooling * seconds);
  for (float& heat : heat_.samples) heat *= warm;
  for_each(threads_, density_,
           [&](int i, int j, int k) { density_(i, j, k) = std::max(0.0f, density_(i, j, k) * keep - lose); });
}

void Solver::add_sources(std::span<const Source> sources, float seconds) {
  const float h = 1 / static_cast<float>(n_);
  const float follow = 1 - std::exp(-30 * seconds); // the air takes the source's velocity within 1/30 s
  for (const Source& source : sources) {
    const auto blend = [&](Grid& grid, Vec3 offset, float speed) {
      for_each(threads_, grid, [&](int i, int j, int k) {
        float& value = grid(i, j, k);
        value += follow * inside(source, h * place(i, j, k, offset)) * (speed - value);
      });
    };
    blend(u_, u_offset, source.velocity.x);
    blend(v_, v_offset, source.velocity.y);
    blend(w_, w_offset, source.velocity.z);
    for_each(threads_, density_, [&](int i, int j, int k) {
      float& value = density_(i, j, k);
      value = std::max(value, source.density * inside(source, h * place(i, j, k, centre_offset)));
    });
    for_each(threads_, heat_, [&](int i, int j, int k) {
      const bool blows = source.density > 0;
      if (blows) heat_(i, j, k) = std::max(heat_(i, j, k), inside(source, h * place(i, j, k, centre_offset)));
    });
  }
}

void Solver::add_forces(float seconds, const Physics& physics) {
  const int n = n_;
  const auto in = [n](int i) { return std::clamp(i, 0, n - 1); };
  const auto velocity = [&](int i, int j, int k) {
    return 0.5f *
           Vec3{u_(i, j, k) + u_(i + 1, j, k), v_(i, j, k) + v_(i, j + 1, k), w_(i, j, k) + w_(i, j, k + 1)};
  };
  const float per_edge = static_cast<float>(n) / 2; // a central difference over two cells -> per cube edge
  for_each(threads_, density_, [&](int i, int j, int k) {
    const Vec3 dx = per_edge * (velocity(in(i + 1), j, k) - velocity(in(i - 1), j, k));
    const Vec3 dy = per_edge * (velocity(i, in(j + 1), k) - velocity(i, in(j - 1), k));
    const Vec3 dz = per_edge * (velocity(i, j, in(k + 1)) - velocity(i, j, in(k - 1)));
    const Vec3 curl{dy.z - dz.y, dz.x - dx.z, dx.y - dy.x};
    curl_[density_.index(i, j, k)] = curl;
    curl_size_(i, j, k) = length(curl);
  });

  // origin_ holds the acceleration at the centres: towards the vortex cores across the curl, and upwards
  // where there is smoke.
  const float strength = physics.confinement / static_cast<float>(n);
  for_each(threads_, density_, [&](int i, int j, int k) {
    const Grid& s = curl_size_;
    const Vec3 gradient{s(in(i + 1), j, k) - s(in(i - 1), j, k), s(i, in(j + 1), k) - s(i, in(j - 1), k),
                        s(i, j, in(k + 1)) - s(i, j, in(k - 1))};
    const size_t at = density_.index(i, j, k);
    Vec3 force = (strength / (length(gradient) + 1e-6f)) * cross(gradient, curl_[at]);
    force.y += physics.buoyancy * density_.samples[at];
    origin_[at] = (seconds / 2) * force;
  });

  // A face gets the mean of its two cells; faces in the walls stay closed.
  for_each(threads_, density_, [&](int i, int j, int k) {
    const auto mean = [&](int a, int b, int c) {
      return origin_[density_.index(i, j, k)] + origin_[density_.index(a, b, c)];
    };
    if (i > 0) u_(i, j, k) += mean(i - 1, j, k).x;
    if (j > 0) v_(i, j, k) += mean(i, j - 1, k).y;
    if (k > 0) w_(i, j, k) += mean(i, j, k - 1).z;
  });
}

// Makes the velocity free of divergence: subtracts the gradient of a pressure.
void Solver::project() {
  for_each(threads_, u_, [&](int i, int j, int k) { u_(i, j, k) *= i > 0 && i < n_ ? 1.0f : 0.0f; });
  for_each(threads_, v_, [&](int i, int j, int k) { v_(i, j, k) *= j > 0 && j < n_ ? 1.0f : 0.0f; });
  for_each(threads_, w_, [&](int i, int j, int k) { w_(i, j, k) *= k > 0 && k < n_ ? 1.0f : 0.0f; });
  Grid& rhs = poisson_.rhs();
  for_each(threads_, rhs, [&](int i, int j, int k) {
    rhs(i, j, k) =
        u_(i + 1, j, k) - u_(i, j, k) + v_(i, j + 1, k) - v_(i, j, k) + w_(i, j, k + 1) - w_(i, j, k);
  });
  poisson_.solve(3);
  const Grid& p = poisson_.pressure();
  for_each(threads_, p, [&](int i, int j, int k) {
    if (i > 0) u_(i, j, k) -= p(i, j, k) - p(i - 1, j, k);
    if (j > 0) v_(i, j, k) -= p(i, j, k) - p(i, j - 1, k);
    if (k > 0) w_(i, j, k) -= p(i, j, k) - p(i, j, k - 1);
  });
}

float Solver::divergence() {
  float largest = 0;
  for_each(1, density_, [&](int i, int j, int k) {
    const float d =
        u_(i + 1, j, k) - u_(i, j, k) + v_(i, j + 1, k) - v_(i, j, k) + w_(i, j, k + 1) - w_(i, j, k);
    largest = std::max(largest, std::fabs(d));
  });
  return largest;
}

Vec3 Solver::velocity_at(Vec3 cells) const {
  return {interpolate(u_, cells - u_offset), interpolate(v_, cells - v_offset),
          interpolate(w_, cells - w_offset)};
}

void Solver::advect(float seconds) {
  const float cells_per_speed = seconds * static_cast<float>(n_);
  advect_one(density_, next_density_, centre_offset, cells_per_speed);
  if (has_heat_) advect_one(heat_, next_heat_, centre_offset, cells_per_speed);
  advect_one(u_, next_u_, u_offset, cells_per_speed);
  advect_one(v_, next_v_, v_offset, cells_per_speed);
  advect_one(w_, next_w_, w_offset, cells_per_speed);
  std::swap(density_, next_density_);
  std::swap(heat_, next_heat_);
  std::swap(u_, next_u_);
  std::swap(v_, next_v_);
  std::swap(w_, next_w_);
}

// The MacCormack method carries the field along, carries the result back, and takes half of what that lost as
// correction, kept within the values it came from.
void Solver::advect_one(const Grid& from, Grid& to, Vec3 offset, float cells_per_speed) {
  for_each(threads_, from, [&](int i, int j, int k) {
    const Vec3 here = place(i, j, k, offset);
    const Vec3 halfway = here - 0.5f * cells_per_speed * velocity_at(here);
    const Vec3 origin = here - cells_per_speed * velocity_at(halfway) - offset;
    const size_t at = from.index(i, j, k);
    origin_[at] = origin;
    to.samples[at] = interpolate(from, origin);
  });
  for_each(threads_, from, [&](int i, int j, int k) {
    const size_t at = from.index(i, j, k);
    const Vec3 origin = origin_[at];
    const Vec3 here = place(i, j, k, {0, 0, 0});
    const float lost = from.samples[at] - interpolate(to, here + (here - origin));
    const Corner c = corner(from, origin);
    const float* s = from.samples.data() + c.at;
    const auto [least, most] = std::minmax(
        {s[0], s[1], s[c.dy], s[c.dy + 1], s[c.dz], s[c.dz + 1], s[c.dz + c.dy], s[c.dz + c.dy + 1]});
    corrected_[at] = std::clamp(to.samples[at] + 0.5f * lost, least, most);
  });
  for_each(threads_, from, [&](int i, int j, int k) {
    const size_t at = from.index(i, j, k);
    to.samples[at] = corrected_[at];
  });
}

} // namespace smoke
