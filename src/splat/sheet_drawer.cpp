// SPDX-License-Identifier: Apache-2.0
// Settles how the sheets of a shot are drawn: their options, the noise that the kernel's form leaves, and
// whether its tables need integrals, which the points decide.
#include "splat/sheet_drawer.h"

#include <deque>
#include <vector>

#include "shade/preintegrate.h"
#include "splat/points/kept_points.h"
#include "splat/points/value_change.h"
#include "splat/sheet_settings.h"
#include "splat/splat.h"
#include "splat/splat_together.h"

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

// A shot as the sheets see it, and what is made for that.
class ShotScene {
 public:
  ShotScene(const Shot& shot, const SplatOptions& options, const Context& context)
      : points_((shot.points ? shot.points : &of_picture_)->of(*shot.slice, context)), table_(*shot.table),
        lights_(lights_of(shot, options.kernel_form)) {
    const Integrals integrals(shot, points_);
    if (options.mode == RenderMode::composite && integrals.needed_by_slice(table_))
      table_.integrals = integrate_values(*shot.function, table_);
    integrated = !table_.integrals.empty(), points_total = points_.count;
    object.scene = {shot.slice, &points_, shot.view, &table_, &lights_, shot.sums, nullptr, shot.light};
    if (shot.paint) paint_by(*shot.paint, shot.sums, context);
    if (shot.trail) trail_by(*shot.trail, integrals);
  }
  ShotScene(const ShotScene&) = delete;
  ShotScene& operator=(const ShotScene&) = delete;

  SplatObject object;
  bool integrated = false; // a table of it
  uint64_t points_total = 0;

 private:
  void paint_by(const ShotPaint& by, KeptLatticeSums* sums, const Context& context) {
    const SplatPoints& points = (by.points ? by.points : &of_paint_)->of(*by.slice, context);
    paint_ = {by.slice, &points, by.view, by.table, &lights_, sums, nullptr, nullptr};
    object.scene.paint = &paint_;
    points_total += points.count;
  }

  void trail_by(const ShotTrail& trail, const Integrals& integrals) {
    trail_tables_ = integrals.tables_of(trail);
    for (const ClassTable& t : trail_tables_) integrated = integrated || !t.integrals.empty();
    for (const ShotTrail::Source& s : trail.sources) {
      object.sources.push_back(
          {s.slice, s.points, s.view, &trail_tables_.front(), &lights_, object.scene.sums, nullptr, nullptr});
      points_total += s.points->count;
    }
    for (const ShotStill& s : trail.stills) {
      object.stills.push_back({s.shares, &trail_tables_[s.function], s.weight, s.frame});
      object.stills.back().lit = !trail.unlit;
    }
    object.combine = trail.combine;
  }

  KeptPoints of_picture_, of_paint_;
  const SplatPoints& points_;
  ClassTable table_;
  Lights lights_;
  SplatScene paint_;
  std::vector<ClassTable> trail_tables_;
};

// What shots that share their sheets are drawn by: as finely as the one that asks for most.
SplatOptions shared_options(Shots shots) {
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

// Whether the sheets of all that is drawn are composited side by side. What has labels, or colours or light
// from elsewhere, is so in mode composite even where it is alone; a trail's slice may be drawn apart.
bool side_by_side(Shots shots) {
  const Shot& shot = *shots.front();
  return shots.size() > 1 || ((shot.paint || shot.light || shot.slice->labels) && !shot.trail &&
                              shot.options.mode == RenderMode::composite);
}

} // namespace

void SheetDrawer::prepare(Shots shots, const Context& context) {
  for (const Shot* shot : shots) {
    if (shot->points) (void)shot->points->of(*shot->slice, context);
    if (shot->paint && shot->paint->points) (void)shot->paint->points->of(*shot->paint->slice, context);
  }
}

DrawStats SheetDrawer::draw(Shots shots, const Context& context,
                            const std::function<void(const TilePixels&)>& emit) {
  SplatOptions options = shared_options(shots);
  std::deque<ShotScene> scenes;
  std::vector<SplatObject> objects;
  uint64_t points_total = 0;
  for (const Shot* shot : shots) {
    const ShotScene& scene = scenes.emplace_back(*shot, options, context);
    options.preintegrate = options.preintegrate || scene.integrated;
    points_total += scene.points_total;
    objects.push_back(scene.object);
  }
  const SplatObject& first = objects.front();
  DrawStats stats = side_by_side(shots) ? splat_together(objects, options, context, emit)
                    : shots[0]->trail
                        ? splat_with_trail(first, options, context, emit)
                        : splat(first.scene, options, context, emit, shots[0]->points ? &kept_ : nullptr);
  stats.points_total += points_total;
  stats.preintegrated = options.preintegrate;
  return stats;
}

} // namespace bccsplat
