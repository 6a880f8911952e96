// SPDX-License-Identifier: Apache-2.0
// The drawers of this build, with all that they keep from picture to picture.
#pragma once

#include <functional>
#include <memory>
#include <span>
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
  // Returns the first drawer that covers the shot; sheets cover all. Throws unsupported where a GPU is asked
  // for and does not cover it, with the reason, and missing_feature where there is none.
  [[nodiscard]] Drawer& drawer_of(const Shot& shot, const DrawerChoice& choice);
  // What the kernel makes of a constant, as earlier pictures looked it up.
  KeptLatticeSums sums;
  // Light on its way through the volume, as an earlier picture followed it.
  KeptLight light;
  // The cells that rays have to look at, from picture to picture.
  [[nodiscard]] KeptSurfaceCells& surface_cells();
  // Returns whether a GPU draws these together (draw_together_by_gpu()). Throws as drawer_of() does where one
  // is asked for and does not.
  [[nodiscard]] bool gpu_draws_together(std::span<const Shot* const> shots, const DrawerChoice& choice);
  // As draw_together(). Throws GpuFailure, too; nothing was emitted then.
  DrawStats draw_together_by_gpu(std::span<const Shot* const> shots, const Context& context,
                                 const std::function<void(const TilePixels&)>& emit);
  // Drops what was kept of earlier slices, which may then go.
  void forget();

 private:
  // Whether a GPU is asked for, or preferred; it is what gpu_ draws by then.
  [[nodiscard]] bool wants_gpu(const DrawerChoice& choice);
  // Null where the CPU draws.
  [[nodiscard]] Drawer* gpu_drawer_of(const Shot& shot, const DrawerChoice& choice);

  std::unique_ptr<GpuDrawer> gpu_;
  RayDrawer* rays_ = nullptr;
  std::vector<std::unique_ptr<Drawer>> drawers_; // by preference, sheets last
};

// Draws several shots of mode composite, with their trails, into one picture: their views have the same
// pixels and sheets, each of its own lattice. `emit` is as Drawer's; depths of tiles are those of the first
// view.
DrawStats draw_together(std::span<const Shot* const> shots, const Context& context,
                        const std::function<void(const TilePixels&)>& emit);

// Draws nothing into a host's texture, of whose context `gpu` is. Throws GpuFailure.
void draw_nothing(const GpuTarget& target, GpuDevice& gpu);

} // namespace bccsplat
