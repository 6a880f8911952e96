// SPDX-License-Identifier: Apache-2.0
// The one file that knows which drawers there are.
#include "scene/drawers.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#if BCCSPLAT_WITH_GPU
#include "gpu/gpu_covers.h"
#include "gpu/gpu_drawer.h"
#include "gpu/gpu_picture.h"
#endif
#if BCCSPLAT_WITH_SPLAT
#include "rays/rays.h"
#include "splat/sheet_drawer.h"
#endif

namespace bccsplat {

#if !BCCSPLAT_WITH_GPU
class GpuDrawer {};
#endif

#if BCCSPLAT_WITH_SPLAT
Drawers::Drawers() : gpu_(std::make_unique<GpuDrawer>()) {
  auto rays = std::make_unique<RayDrawer>();
  rays_ = rays.get();
  drawers_.push_back(std::move(rays));
  drawers_.push_back(std::make_unique<SheetDrawer>());
}

KeptSurfaceCells& Drawers::surface_cells() { return rays_->cells(); }
#else
Drawers::Drawers() : gpu_(std::make_unique<GpuDrawer>()) {}
#endif

Drawers::~Drawers() = default;

#if BCCSPLAT_WITH_GPU
Drawer* Drawers::gpu_drawer_of(Shots shots, const DrawerChoice& choice) {
  if (choice.backend == Backend::cpu || !choice.gpu) return nullptr;
  const bool asked = choice.backend == Backend::gpu || !has_cpu_drawers;
  if (!asked && !choice.gpu->preferred()) return nullptr;
  gpu_->use(choice.gpu);
  const char* const what = not_on_gpu(shots);
  if (what && asked)
    fail(Code::unsupported, "render: the GPU does not draw ", what,
         has_cpu_drawers ? "; let the CPU draw it" : ", and this build has no drawers of the CPU's");
  return what ? nullptr : gpu_.get();
}

void draw_nothing(const GpuTarget& target, GpuDevice& gpu) {
  gpu.run([&] { lay_nothing_over(target); });
}
#else
void draw_nothing(const GpuTarget& /*target*/, GpuDevice& /*gpu*/) {} // there is no such target
Drawer* Drawers::gpu_drawer_of(Shots /*shots*/, const DrawerChoice& choice) {
  if (choice.backend == Backend::gpu) (void)gpu_info(nullptr);
  return nullptr;
}
#endif

Drawer& Drawers::drawer_of(Shots shots, const DrawerChoice& choice) {
  const bool scattered =
      std::any_of(shots.begin(), shots.end(), [](const Shot* s) { return s->slice->scattered != nullptr; });
  if (scattered && choice.backend == Backend::gpu)
    fail(Code::unsupported, "render: the GPU does not draw extracted points; let the CPU draw them");
  if (scattered) return *drawers_.back();
  if (Drawer* const drawer = gpu_drawer_of(shots, choice)) return *drawer;
  if (!has_cpu_drawers)
    fail(Code::missing_feature,
         "render: the library was built without drawers of the CPU's; draw by a GPU, or build it with "
         "BCCSPLAT_WITH_SPLAT");
  if (choice.sheets_only) return *drawers_.back();
  return **std::find_if(drawers_.begin(), drawers_.end() - 1,
                        [&](const auto& drawer) { return drawer->covers(shots); });
}

void Drawers::forget() {
#if BCCSPLAT_WITH_GPU
  gpu_->forget();
#endif
  for (const auto& drawer : drawers_) drawer->forget();
  light.forget();
}

} // namespace bccsplat
