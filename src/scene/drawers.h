// SPDX-License-Identifier: Apache-2.0
// The drawers of this build, with all that they keep from picture to picture.
#pragma once

#include <memory>
#include <vector>

#include "draw/drawer.h"
#include "field/lattice_sums.h"
#include "scene/backend.h"
#include "scene/kept_light.h"

namespace bccsplat {

// Whether there are drawers of the CPU's; without them what the GPU does not draw is refused.
#if BCCSPLAT_WITH_SPLAT
inline constexpr bool has_cpu_drawers = true;
#else
inline constexpr bool has_cpu_drawers = false;
#endif

class GpuDrawer;        // gpu/gpu_drawer.h
class KeptSurfaceCells; // rays/surface_cells.h
class RayDrawer;        // rays/rays.h

// What a picture may be drawn by.
struct DrawerChoice {
  bool sheets_only = false; // of the CPU's
  Backend backend = Backend::cpu;
  std::shared_ptr<GpuDevice> gpu; // null: none
};

class Drawers {
 public:
  Drawers();
  ~Drawers();
  // Returns the first drawer that covers the shots; sheets cover all. Throws unsupported where a GPU is asked
  // for and does not cover them, with the reason, and missing_feature where there is none.
  [[nodiscard]] Drawer& drawer_of(Shots shots, const DrawerChoice& choice);
  // What the kernel makes of a constant, as earlier pictures looked it up.
  KeptLatticeSums sums;
  // Light on its way through the volume, as an earlier picture followed it.
  KeptLight light;
  // The cells that rays have to look at, from picture to picture.
  [[nodiscard]] KeptSurfaceCells& surface_cells();
  // Drops what was kept of earlier slices, which may then go.
  void forget();

 private:
  // Null where the CPU draws.
  [[nodiscard]] Drawer* gpu_drawer_of(Shots shots, const DrawerChoice& choice);

  std::unique_ptr<GpuDrawer> gpu_;
  RayDrawer* rays_ = nullptr;
  std::vector<std::unique_ptr<Drawer>> drawers_; // by preference, sheets last
};

// Draws nothing into a host's texture, of whose context `gpu` is. Throws GpuFailure.
void draw_nothing(const GpuTarget& target, GpuDevice& gpu);

} // namespace bccsplat
