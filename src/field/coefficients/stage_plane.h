// SPDX-License-Identifier: Apache-2.0
// One prefilter stage on one plane of one layer: sums over planes that lie in memory row by row, margins
// included (formula: PrefilterStage in kernel/kernel.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace bccsplat {

// A plane's share of a sum; `at` is its first site.
struct PlaneTerm {
  const float* at = nullptr;
  float weight = 0;
};
// Products are added in this order.
struct PlaneTerms {
  static constexpr size_t most = 6;
  std::array<PlaneTerm, most> term;
  size_t count = 0;
  void add(const float* at, float weight) { term[count++] = {at, weight}; }
};

// Sites of a plane that are written, row by row; up to a vector of sites behind a row may be written as well.
struct PlaneBox {
  int width = 0, height = 0;
  std::ptrdiff_t stride = 0; // of all planes
};

// to = the weighted sum of planes.
void sum_planes(const PlaneTerms& terms, const PlaneBox& box, float* to);

// to = the sums of the four sites (x or x + span, y or y + span) of first + second; null: there is no second.
void sum_corners(const float* first, const float* second, int span, const PlaneBox& box, float* to);

// What a stage adds up for one plane.
struct StagePlane {
  PlaneTerms centre;
  // Planes whose six neighbours are summed: the ones before, at and behind the plane. null: none.
  std::array<const float*, 3> neighbours{};
  // Sums of corners in the two planes around this one; null: none.
  std::array<const float*, 2> corners{};
  float cross = 0; // their weight
};
void sum_stage(const StagePlane& plane, const PlaneBox& box, float* to);

// Fills a plane of a brick: keeps the values inside the box that are above `prune` in magnitude, clears the
// others, and tells the bits of those that are kept. Returns whether there are any.
bool keep_plane(const float* from, const PlaneBox& box, float prune, float* to, uint16_t* kept);

} // namespace bccsplat
