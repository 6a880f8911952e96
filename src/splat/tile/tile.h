// SPDX-License-Identifier: Apache-2.0
// Draws one tile of a picture, front to back: of one set of points, or of several side by side.
#pragma once

#include <span>

#include "splat/plan/plan.h"
#include "splat/tile/kept_sheets.h"
#include "splat/tile/tile_memory.h"

namespace bccsplat {

// A set of points with everything that is planned for it.
struct TileObject {
  const SplatScene* scene = nullptr;
  SplatPlan plan;
  KernelPolynomial kernel;
  bool own_rays = false; // its domain is not the picture's
};

// Stills are composited in two groups: 0 and 1, joined by the rule. Each pair is joined by its own rule
// before its extinction is added to group 1; pair n has the groups joined_groups + 2 n and the one behind it.
inline constexpr size_t joined_groups = 2;

struct TileJob {
  std::span<const TileObject> objects; // whose sheets and tiles are alike
  // What is made of them: mode composite. None: of one object its own field is drawn, in any mode.
  std::span<const SplatStill> stills{};
  TrailCombine combine = TrailCombine::physical;
  std::span<const TrailCombine> pairs{};
  const SplatOptions* options = nullptr;
  const Context* context = nullptr;
  const SplatScene* main = nullptr; // whose rays are the picture's
  // For one object that is drawn without stills.
  KeptSheets* kept = nullptr;
  KeptSheets::Use use = KeptSheets::Use::draw;

  [[nodiscard]] bool alone() const { return stills.empty(); }
  [[nodiscard]] size_t groups() const { return joined_groups + 2 * pairs.size(); }
};

// Draws tile `n` of every plan; the pixels stay in `memory`. front (may be null): a picture of a surface,
// which ends the rays that it covers at its depth with its colour.
TilePixels draw_tile(const TileJob& job, size_t n, const TilePixels* front, TileMemory& memory,
                     DrawStats& stats);

} // namespace bccsplat
