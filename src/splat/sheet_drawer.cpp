// SPDX-License-Identifier: Apache-2.0
// Settles how the sheets of a shot are drawn: their options, the noise that the kernel's form leaves, and
// whether its tables need integrals, which the points decide.
#include "splat/sheet_drawer.h"

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

// Draws the slice of `scene` with the shot's trail.
DrawStats draw_with_trail(const Shot& shot, const SplatScene& scene, SplatOptions& options,
                          const Context& context, const std::function<void(const TilePixels&)>& emit) {
  const ShotTrail& trail = *shot.trail;
  const std::vector<ClassTable> tables = Integrals(shot, *scene.points).tables_of(trail);
  for (const ClassTable& t : tables) options.preintegrate = options.preintegrate || !t.integrals.empty();
  std::vector<SplatScene> sources;
  for (const ShotTrail::Source& s : trail.sources)
    sources.push_back({s.slice, s.points, s.view, &tables.front(), scene.lights, scene.sums});
  std::vector<TrailStill> stills;
  for (const ShotStill& s : trail.stills)
    stills.push_back({s.shares, &tables[s.function], s.weight, s.frame});
  DrawStats stats = splat_with_trail(scene, sources, stills, trail.combine, options, context, emit);
  for (const SplatScene& s : sources) stats.points_total += s.points->count;
  return stats;
}

} // namespace

void SheetDrawer::prepare(const Shot& shot, const Context& context) {
  if (shot.points) (void)shot.points->of(*shot.slice, context);
}

DrawStats SheetDrawer::draw(const Shot& shot, const Context& context,
                            const std::function<void(const TilePixels&)>& emit) {
  SplatOptions options = sheet_options(shot);
  const KeptPoints of_picture;
  const SplatPoints& points = (shot.points ? shot.points : &of_picture)->of(*shot.slice, context);
  const Lights lights = lights_of(shot, options.kernel_form);
  ClassTable table = *shot.table;
  if (options.mode == RenderMode::composite && Integrals(shot, points).needed(*shot.function, table))
    table.integrals = integrate_values(*shot.function, table);
  options.preintegrate = !table.integrals.empty();
  const SplatScene scene{shot.slice, &points, shot.view, &table, &lights, shot.sums};
  DrawStats stats = shot.trail ? draw_with_trail(shot, scene, options, context, emit)
                               : splat(scene, options, context, emit, shot.points ? &kept_ : nullptr);
  stats.points_total += points.count;
  stats.preintegrated = options.preintegrate;
  return stats;
}

} // namespace bccsplat
