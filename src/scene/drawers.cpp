// SPDX-License-Identifier: Apache-2.0
// The one file that knows which drawers there are.
#include "scene/drawers.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#if BCCSPLAT_WITH_GPU
#include "gpu/gpu_drawer.h"
#include "gpu/gpu_look.h"
#include "gpu/gpu_picture.h"
#include "gpu/object_look.h"
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

DrawStats draw_together(std::span<const Shot* const> shots, const Context& context,
                        const std::function<void(const TilePixels&)>& emit) {
  return draw_sheets_together(shots, context, emit);
}
#else
Drawers::Drawers() : gpu_(std::make_unique<GpuDrawer>()) {}
#endif

Drawers::~Drawers() = default;

#if BCCSPLAT_WITH_GPU
namespace {

bool is_asked(const DrawerChoice& choice) { return choice.backend == Backend::gpu || !has_cpu_drawers; }

void refuse(const char* what) {
  fail(Code::unsupported, "render: the GPU does not draw ", what,
       has_cpu_drawers ? "; let the CPU draw it" : ", and this build has no drawers of the CPU's");
}

} // namespace

bool Drawers::wants_gpu(const DrawerChoice& choice) {
  if (choice.backend == Backend::cpu || !choice.gpu) return false;
  if (!is_asked(choice) && !choice.gpu->preferred()) return false;
  gpu_->use(choice.gpu);
  return true;
}

Drawer* Drawers::gpu_drawer_of(const Shot& shot, const DrawerChoice& choice) {
  if (!wants_gpu(choice)) return nullptr;
  const bool asked = is_asked(choice);
  if (const char* const what = not_on_gpu(shot); what && asked) refuse(what);
  return asked || gpu_->covers(shot) ? gpu_.get() : nullptr;
}

bool Drawers::gpu_draws_together(std::span<const Shot* const> shots, const DrawerChoice& choice) {
  if (!wants_gpu(choice)) return false;
  const bool trails =
      std::any_of(shots.begin(), shots.end(), [](const Shot* s) { return s->trail != nullptr; });
  const char* const what =
      trails ? "trails among several instances" : not_as_objects(instance_objects(shots));
  if (what && is_asked(choice)) refuse(what);
  return !what;
}

DrawStats Drawers::draw_together_by_gpu(std::span<const Shot* const> shots, const Context& context,
                                        const std::function<void(const TilePixels&)>& emit) {
  return gpu_->draw_together(shots, context, emit);
}

void draw_nothing(const GpuTarget& target, GpuDevice& gpu) {
  gpu.run([&] { lay_nothing_over(target); });
}
#else
void draw_nothing(const GpuTarget& /*target*/, GpuDevice& /*gpu*/) {} // there is no such target
Drawer* Drawers::gpu_drawer_of(const Shot& /*shot*/, const DrawerChoice& choice) {
  if (choice.backend == Backend::gpu) (void)gpu_info(nullptr);
  return nullptr;
}

bool Drawers::gpu_draws_together(std::span<const Shot* const> /*shots*/, const DrawerChoice& choice) {
  if (choice.backend == Backend::gpu) (void)gpu_info(nullptr);
  return false;
}

DrawStats Drawers::draw_together_by_gpu(std::span<const Shot* const> /*shots*/, const Context& /*context*/,
                                        const std::function<void(const TilePixels&)>& /*emit*/) {
  return {};
}
#endif

Drawer& Drawers::drawer_of(const Shot& shot, const DrawerChoice& choice) {
  if (shot.slice->scattered && choice.backend == Backend::gpu)
    fail(Code::unsupported, "render: the GPU does not draw extracted points; let the CPU draw them");
  if (shot.slice->scattered) return *drawers_.back();
  if (Drawer* const drawer = gpu_drawer_of(shot, choice)) return *drawer;
  if (!has_cpu_drawers)
    fail(Code::missing_feature,
         "render: the library was built without drawers of the CPU's; draw by a GPU, or build it with "
         "BCCSPLAT_WITH_SPLAT");
  if (choice.sheets_only) return *drawers_.back();
  return **std::find_if(drawers_.begin(), drawers_.end() - 1,
                        [&](const auto& drawer) { return drawer->covers(shot); });
}

void Drawers::forget() {
#if BCCSPLAT_WITH_GPU
  gpu_->forget();
#endif
  for (const auto& drawer : drawers_) drawer->forget();
  light.forget();
}

} // namespace bccsplat
