// SPDX-License-Identifier: Apache-2.0
// Settles how the sheets of a shot are drawn: their options, the noise that the kernel's form leaves, and
// whether its tables need integrals, which the points decide.
#include "splat/sheet_drawer.h"

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "shade/preintegrate.h"
#include "splat/points/kept_points.h"
#include "splat/points/value_change.h"
#include "splat/sheet_settings.h"
#include "splat/splat.h"
#include "splat/trail/trail.h"

namespace bccsplat {
namespace {

// Decides whether segments are classified by integrals: where the transfer function is narrower than the
// change of the field from sheet to sheet, in any direction.
class Integrals {
 public:
  Integrals(const Shot& shot, const SplatPoints& points) : shot_(shot), points_(points) {}

  [[nodiscard]] bool needed(const TransferFunction& function, const ClassTable& table) const {
    if (shot_.preintegrate != Preintegrate::automatic) return shot_.preintegrate == Preintegrate::on;
    const double change = shot_.view->step * change_per_unit(*shot_.slice, points_);
    return narrowness(function, table, change, shot_.view->step_world) >= narrow_function;
  }
  // The same of the slice itself: between labels lies nothing, whatever the trail beside them asks for.
  [[nodiscard]] bool needed_by_slice(const ClassTable& table) const {
    return !shot_.slice->labels && needed(*shot_.function, table);
  }
  // Returns the tables of a trail, all with integrals where one of its functions asks for them. The change
  // from sheet to sheet is taken from the slice, of which the trail is the past.
  [[nodiscard]] std::vector<ClassTable> tables_of(const ShotTrail& trail) const {
    std::vector<ClassTable> tables = trail.tables;
    bool any = false;
    for (size_t n = 0; n < tables.size() && !any; ++n) any = needed(trail.functions[n], tables[n]);
    for (size_t n = 0; n < tables.size() && any; ++n)
      tables[n].integrals = integrate_values(trail.functions[n], tables[n]);
    return tables;
  }

 private:
  const Shot& shot_;
  const SplatPoints& points_;
};

// The trail of a shot as the sheets see it: sources and stills of `scene`, the slice that it goes with.
class TrailScenes {
 public:
  TrailScenes(const Shot& shot, const SplatScene& scene) {
    if (!shot.trail) return;
    const ShotTrail& trail = *shot.trail;
    tables_ = Integrals(shot, *scene.points).tables_of(trail);
    for (const ShotTrail::Source& s : trail.sources)
      sources.push_back(
          {s.slice, s.points, s.view, &tables_.front(), scene.lights, scene.sums, nullptr, nullptr});
    for (const ShotStill& s : trail.stills) {
      stills.push_back({s.shares, &tables_[s.function], s.weight, s.frame});
      stills.back().lit = !trail.unlit;
    }
  }
  [[nodiscard]] bool integrated() const {
    return std::any_of(tables_.begin(), tables_.end(),
                       [](const ClassTable& t) { return !t.integrals.empty(); });
  }
  [[nodiscard]] uint64_t points() const {
    uint64_t sum = 0;
    for (const SplatScene& s : sources) sum += s.points->count;
    return sum;
  }

  std::vector<SplatScene> sources;
  std::vector<TrailStill> stills;

 private:
  std::vector<ClassTable> tables_;
};

// Draws the slice of `scene` with the shot's trail.
DrawStats draw_with_trail(const Shot& shot, const SplatScene& scene, SplatOptions& options,
                          const Context& context, const std::function<void(const TilePixels&)>& emit) {
  const TrailScenes trail(shot, scene);
  options.preintegrate = options.preintegrate || trail.integrated();
  DrawStats stats =
      splat_with_trail(scene, trail.sources, trail.stills, shot.trail->combine, options, context, emit);
  stats.points_total += trail.points();
  return stats;
}

} // namespace

void SheetDrawer::prepare(const Shot& shot, const Context& context) {
  if (shot.points) (void)shot.points->of(*shot.slice, context);
  if (shot.paint && shot.paint->points) (void)shot.paint->points->of(*shot.paint->slice, context);
}

namespace {

// What a shot is painted by, as the sheets see it; null where it is not.
class PaintScene {
 public:
  PaintScene(const Shot& shot, const Lights& lights, const Context& context) {
    if (!shot.paint) return;
    const ShotPaint& paint = *shot.paint;
    const SplatPoints& points = (paint.points ? paint.points : &of_picture_)->of(*paint.slice, context);
    scene_ = {paint.slice, &points, paint.view, paint.table, &lights, shot.sums, nullptr, nullptr};
  }
  [[nodiscard]] const SplatScene* get() const { return scene_.slice ? &scene_ : nullptr; }
  [[nodiscard]] uint64_t points() const { return scene_.slice ? scene_.points->count : 0; }

 private:
  KeptPoints of_picture_;
  SplatScene scene_;
};

// What shots that share their sheets are drawn by: as finely as the one that asks for most.
SplatOptions shared_options(std::span<const Shot* const> shots) {
  SplatOptions shared = sheet_options(*shots.front());
  bool differences = false; // the kernel's own gradient is not known to all
  for (const Shot* shot : shots) {
    const SplatOptions o = sheet_options(*shot);
    if (o.kernel_form == KernelForm::exact) shared.kernel_form = KernelForm::exact;
    if (o.gradient == GradientMethod::analytic) shared.gradient = o.gradient;
    differences = differences || shot->slice->kernel.normalised || corrected(*shot);
    shared.disable_skips |= o.disable_skips;
  }
  if (differences && shared.gradient == GradientMethod::analytic)
    shared.gradient = GradientMethod::fourth_order;
  return shared;
}

} // namespace

DrawStats draw_sheets_together(std::span<const Shot* const> shots, const Context& context,
                               const std::function<void(const TilePixels&)>& emit) {
  SplatOptions options = shared_options(shots);
  const std::vector<KeptPoints> of_picture(shots.size());
  std::vector<ClassTable> tables;
  std::vector<Lights> lights;
  std::vector<SplatObject> scenes;
  std::deque<PaintScene> paints;
  std::deque<TrailScenes> trails;
  tables.reserve(shots.size()), lights.reserve(shots.size());
  uint64_t points_total = 0;
  for (size_t n = 0; n < shots.size(); ++n) {
    const Shot& shot = *shots[n];
    const SplatPoints& points = (shot.points ? shot.points : &of_picture[n])->of(*shot.slice, context);
    ClassTable& table = tables.emplace_back(*shot.table);
    if (Integrals(shot, points).needed_by_slice(table))
      table.integrals = integrate_values(*shot.function, table), options.preintegrate = true;
    const Lights& lit = lights.emplace_back(lights_of(shot, options.kernel_form));
    const PaintScene& paint = paints.emplace_back(shot, lit, context);
    const SplatScene scene{shot.slice, &points, shot.view, &table, &lit, shot.sums, paint.get(), shot.light};
    const TrailScenes& trail = trails.emplace_back(shot, scene); // whose tables stay where they are
    options.preintegrate = options.preintegrate || trail.integrated();
    scenes.push_back(
        {scene, trail.sources, trail.stills, shot.trail ? shot.trail->combine : TrailCombine::physical});
    points_total += points.count + paint.points() + trail.points();
  }
  DrawStats stats = splat_together(scenes, options, context, emit);
  stats.points_total += points_total;
  stats.preintegrated = options.preintegrate;
  return stats;
}

DrawStats SheetDrawer::draw(const Shot& shot, const Context& context,
                            const std::function<void(const TilePixels&)>& emit) {
  // What has labels, or colours or light from elsewhere, has sheets side by side.
  if ((shot.paint || shot.light || shot.slice->labels) && !shot.trail &&
      shot.options.mode == RenderMode::composite) {
    const std::array<const Shot*, 1> alone{&shot};
    return draw_sheets_together(alone, context, emit);
  }
  SplatOptions options = sheet_options(shot);
  const KeptPoints of_picture;
  const SplatPoints& points = (shot.points ? shot.points : &of_picture)->of(*shot.slice, context);
  const Lights lights = lights_of(shot, options.kernel_form);
  ClassTable table = *shot.table;
  if (options.mode == RenderMode::composite && Integrals(shot, points).needed_by_slice(table))
    table.integrals = integrate_values(*shot.function, table);
  options.preintegrate = !table.integrals.empty();
  const PaintScene paint(shot, lights, context);
  const SplatScene scene{shot.slice, &points, shot.view, &table, &lights, shot.sums, paint.get(), nullptr};
  DrawStats stats = shot.trail ? draw_with_trail(shot, scene, options, context, emit)
                               : splat(scene, options, context, emit, shot.points ? &kept_ : nullptr);
  stats.points_total += points.count;
  stats.preintegrated = options.preintegrate;
  return stats;
}

} // namespace bccsplat
