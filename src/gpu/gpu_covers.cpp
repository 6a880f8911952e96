// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_covers.h"

#include <algorithm>
#include <span>

#include "gpu/object_look.h"

namespace bccsplat {
namespace {

// Sheet numbers that floats count by, with room for their fractions.
constexpr int64_t most_sheet = 1 << 20;
constexpr int most_entries = 1 << 16;

bool too_many_sheets(const Shot& shot) {
  const auto [first, last] = sheet_range(*shot.slice, *shot.view);
  return first < -most_sheet || last > most_sheet;
}

bool mends(const Slice& s) { return s.corrections || s.mask || s.has_holes; }

bool like(const Slice& a, const Slice& b) {
  return a.lattice.bcc == b.lattice.bcc && a.kernel.name == b.kernel.name;
}

const char* not_with_trail(const Shot& shot);

const char* not_alone(const Shot& shot) {
  const Slice& slice = *shot.slice;
  constexpr size_t sides_of_a_box = 6;
  if (shot.paint) return "colours by another channel";
  if (slice.labels && shot.options.mode == RenderMode::composite) return "labels";
  if (shot.light) return "shadows and ambient occlusion";
  if (shot.trail) return not_with_trail(shot);
  if (shot.options.with_deep) return "a deep picture";
  if (shot.options.with_hits) return "smooth edges of several surfaces or transparent ones";
  if (slice.empty()) return "an empty slice";
  if (slice.mask && !slice.mask->grid()) return "missing data along uneven axes or in an oblique slice";
  if (slice.kernel.space.radius > 2 * coset_pitch(slice.lattice.bcc)) return "a kernel that wide";
  if (slice.clip.size() + shot.view->clip.size() + sides_of_a_box > most_cuts) return "that many clips";
  if (shot.lights->lights.size() > most_gpu_lights) return "that many lights";
  if (shot.options.surfaces.size() > most_gpu_surfaces) return "that many surfaces";
  if (shot.table->size() > most_entries) return "a transfer function of that many entries";
  if (too_many_sheets(shot)) return "that many sheets";
  return nullptr;
}

const char* not_side_by_side(std::span<const GpuObject> objects) {
  if (objects.size() > most_gpu_objects) return "so many stills of a trail, or instances, together";
  for (const GpuObject& o : objects) {
    const Slice& slice = *o.shot.slice;
    if (mends(slice)) return "a trail or several instances with corrections or missing data";
    if (!like(slice, *objects.front().shot.slice)) return "instances of unlike kernels or lattices together";
    if (o.shot.options.shading != objects.front().shot.options.shading)
      return "instances together of which some are too thin to be lit";
    if (const char* const what = not_alone(o.shot)) return what;
  }
  return nullptr;
}

const char* not_with_trail(const Shot& shot) {
  const bool surface = shot.options.mode == RenderMode::isosurface;
  if (surface && shot.target) return "a trail behind a surface into a texture of the host";
  if (surface && shot.trail->combine == TrailCombine::interleaved)
    return "a trail behind a surface that rays go through (interleaved as printed)";
  if (shot.trail->stills.empty()) return "a trail without a moment";
  if (shot.trail->unlit && shot.options.shading) return "a trail that is not lit behind a lit slice";
  for (const ShotStill& still : shot.trail->stills)
    if (still.shares.size() > 1) return "stills that are mixed sheet by sheet";
  if (surface) {
    Shot front = shot;
    front.trail = nullptr;
    if (const char* const what = not_alone(front)) return what;
  }
  return not_side_by_side(trail_objects(shot, !surface));
}

} // namespace

const char* not_on_gpu(Shots shots) {
  if (shots.size() == 1) return not_alone(*shots.front());
  if (std::any_of(shots.begin(), shots.end(), [](const Shot* s) { return s->trail != nullptr; }))
    return "trails among several instances";
  return not_side_by_side(instance_objects(shots));
}

} // namespace bccsplat
