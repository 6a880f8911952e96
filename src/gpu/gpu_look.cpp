// SPDX-License-Identifier: Apache-2.0
// Says of a shot what the shader is compiled for and what it is told: rays and cuts as forms of column and
// row in double precision, light in units near 1, classes with their integrals, and the cells that nothing is
// seen of.
#include "gpu/gpu_look.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernel/cc_kernel.h"
#include "kernel/drawn_kernel.h"
#include "shade/preintegrate.h"
#include "shade/surface.h"

namespace bccsplat {
// To a GPU the shorter forms save nothing, but light shows the ripple that the flat one is without.
KernelForm gpu_form(const Shot& shot) {
  return sample_form(shot) == KernelForm::flat_form ? KernelForm::flat_form : KernelForm::exact;
}

bool asks_for_change(const Shot& shot) {
  return shot.options.mode == RenderMode::composite && shot.preintegrate == Preintegrate::automatic;
}

ClassTable gpu_table(const Shot& shot, double change) {
  ClassTable table = *shot.table;
  if (shot.options.mode != RenderMode::composite || shot.preintegrate == Preintegrate::off) return table;
  if (shot.preintegrate == Preintegrate::on ||
      narrowness(*shot.function, table, shot.view->step * change, shot.view->step_world) >= narrow_function)
    table.integrals = integrate_values(*shot.function, table);
  return table;
}

std::vector<Vec4f> table_texels(const ClassTable& table) {
  std::vector<Vec4f> out = table.entry;
  const ValueIntegrals& t = table.integrals;
  for (size_t j = 0; j < t.moment.size(); ++j) {
    for (size_t part = 0; part < 3; ++part) out.push_back(t.part[3 * j + part]);
    out.push_back(t.moment[j]);
  }
  out.resize((out.size() + table_row - 1) / table_row * table_row);
  return out;
}

ShaderKind shader_kind(const Shot& shot, const ClassTable& table, KernelForm form) {
  ShaderKind kind;
  const ShotOptions& o = shot.options;
  const Kernel& kernel = shot.slice->kernel;
  kind.mode = o.mode;
  kind.shading = o.shading;
  kind.halves = o.mode == RenderMode::composite && o.shading &&
                (shot.lights->diffuse != 0 || shot.lights->specular != 0);
  kind.integrals = !table.integrals.empty(), kind.split = table.integrals.split;
  const Slice& slice = *shot.slice;
  kind.bcc = slice.lattice.bcc;
  if (slice.corrections && !slice.corrections->add.empty()) kind.corrections = slice.corrections->shape;
  kind.masked = slice.mask != nullptr, kind.holes = slice.has_holes && !slice.holes_by_mask;
  kind.normalised = kernel.normalised;
  kind.ripple =
      o.shading && o.without_ripple && !kernel.normalised && !slice.corrections; // as lattice_sums()
  if (kernel.normalised)
    kind.first_wave =
        kind.bcc ? std::exp(-std::numbers::pi * std::numbers::pi / kernel.time.gaussian) : cc_first_wave();
  kind.surfaces = std::max(1, static_cast<int>(o.surfaces.size()));
  kind.kernel = drawn_kernel(kernel.space, form);
  return kind;
}

namespace {

Vec4f vec4f(const Vec3& v, double w = 0) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]),
          static_cast<float>(w)};
}

// A number for each pixel and sheet: constant, per column and per row, from the picture's centre.
struct PixelForm {
  double constant = 0, per_column = 0, per_row = 0;
  [[nodiscard]] Vec4f floats() const { return vec4f({constant, per_column, per_row}); }
};

// The rays of a view, as points at sheet 0 and steps from sheet to sheet.
struct RayForms {
  std::array<Vec3, 3> origin, along;
  RayForms(const SheetView& v, double column, double row)
      : origin{v.sample(column, row, 0), v.scale(0) * v.ex, v.scale(0) * v.ey},
        along{v.ray(column, row), v.perspective ? v.ex : Vec3{}, v.perspective ? v.ey : Vec3{}} {}
  [[nodiscard]] std::array<Vec4f, 2> cut(const Vec3& normal, double offset) const {
    const PixelForm slope{dot(normal, along[0]), dot(normal, along[1]), dot(normal, along[2])},
        value{dot(normal, origin[0]) + offset, dot(normal, origin[1]), dot(normal, origin[2])};
    return {slope.floats(), value.floats()};
  }
};

void set_cuts(const Shot& shot, const RayForms& rays, PictureBlock& b) {
  int count = 0;
  const auto add = [&](const Vec3& normal, double offset) {
    const auto [slope, value] = rays.cut(normal, offset);
    b.cuts[size_t{2} * count] = slope, b.cuts[size_t{2} * count + 1] = value;
    ++count;
  };
  const DrawnBox box = drawn_box(*shot.slice);
  for (size_t a = 0; a < 3; ++a) {
    Vec3 normal{};
    normal[a] = 1;
    add(normal, -box.begin[a]);
    add(-1.0 * normal, box.end[a]);
  }
  for (const auto* const clips : {&shot.slice->clip, &shot.view->clip})
    for (const HalfSpace& h : *clips) add(h.normal, h.offset);
  b.counts[0] = count;
}

void set_rays(const Shot& shot, PictureBlock& b) {
  const SheetView& v = *shot.view;
  const double column = v.width / 2, row = v.height / 2; // whole numbers: pixels are counted from a pixel
  const RayForms rays(v, column, row);
  for (size_t n = 0; n < 3; ++n) {
    b.origin[n] = vec4f(rays.origin[n]), b.along[n] = vec4f(rays.along[n]);
    b.world_along[n] = vec4f(v.lattice_to_world.vector(rays.along[n]));
  }
  set_cuts(shot, rays, b);
  constexpr double far = 1e30, known = 2; // lattice units outside the domain, as sheets have it
  const double first = v.perspective ? static_cast<double>(v.first_sheet()) : -far;
  b.sheets[0] = static_cast<float>(first);
  b.sheets[1] = static_cast<float>(v.perspective || v.in_front ? -v.depth : -far);
  b.sheets[2] = shot.options.opacity_stop < 1 ? static_cast<float>(shot.options.opacity_stop) : 2.0f;
  b.sheets[3] = shot.options.depth_opacity;
  b.centre = vec4f({column, row, known / v.step});
  b.ends = vec4f({1 / v.step_world, -v.depth, 0});
  b.picture = {v.width, v.height, 0, v.ends.distance ? 1 : 0};
  if (const GpuTarget* const t = shot.target; t && t->depth_texture != 0) {
    b.ends[2] = static_cast<float>(t->constant), b.ends[3] = static_cast<float>(t->factor);
    b.picture[3] = (t->perspective ? 2 : 3) * (t->reversed ? -1 : 1);
  }
}

// A power of two that brings x near 1.
double near_one(double x) { return std::isnormal(x) ? std::ldexp(1.0, -std::ilogb(x)) : 1; }

void set_light(const Shot& shot, const ShaderKind& kind, KernelForm form, PictureBlock& b) {
  const Slice& slice = *shot.slice;
  const Lights lights = lights_of(shot, form);
  const Affine3 to_lattice = shot.view->lattice_to_world.inverse();
  std::array<Vec3, 3> columns;
  double longest = 0;
  for (size_t a = 0; a < 3; ++a) {
    Vec3 axis{};
    axis[a] = 1;
    columns[a] = to_lattice.transposed(axis);
    longest = std::max(longest, length(columns[a]));
  }
  // Gradients of any unit have squares that are floats.
  const double base = slice.base, largest = std::max(slice.bounds[1] - base, base - slice.bounds[0]);
  const double enlarged = near_one(longest) * std::min(near_one(largest), 0x1p126);
  for (size_t a = 0; a < 3; ++a) b.to_world[a] = vec4f(enlarged * columns[a]);
  b.noise = vec4f({enlarged * lights.noise.constant, enlarged * lights.noise.of_value, lights.ambient},
                  lights.shininess);
  b.counts[1] = kind.shading ? static_cast<int32_t>(lights.lights.size()) : 0;
  for (size_t n = 0; n < lights.lights.size() && n < most_gpu_lights; ++n) {
    const Light& light = lights.lights[n];
    const bool headlight = dot(light.direction, light.direction) == 0;
    b.lights[n] = headlight ? vec4f({}, 1) : vec4f(normalized(light.direction));
    b.diffuse[n] = vec4f(lights.diffuse * light.color);
    b.specular[n] = vec4f(lights.specular * light.color);
  }
}

void set_surfaces(const Shot& shot, const ClassTable& table, PictureBlock& b) {
  const auto& surfaces = shot.options.surfaces;
  for (size_t n = 0; n < surfaces.size(); ++n) {
    b.surface[2 * n] = vec4f(
        {surfaces[n].value - shot.slice->base, surfaces[n].opacity, surfaces[n].opacity < 1 ? 1.0 : 0.0});
    b.surface[2 * n + 1] = surface_color(surfaces[n], table);
  }
  b.counts[2] = static_cast<int32_t>(surfaces.size());
}

std::array<Vec4f, 3> rows_of(const LatticeForms& forms) {
  std::array<Vec4f, 3> out;
  for (size_t a = 0; a < 3; ++a) out[a] = vec4f(forms.normal[a], forms.offset[a]);
  return out;
}

void set_marks(const FieldBricks& bricks, PictureBlock& b) {
  b.to_fixes = rows_of(bricks.fixes.to_cells), b.to_samples = rows_of(bricks.missing.to_samples);
  for (size_t a = 0; a < 3; ++a) {
    b.fix_bricks[a] = bricks.fixes.bricks[a], b.samples[a] = bricks.missing.bits.size[a];
    b.samples[3] |= bricks.missing.turning[a] ? 1 << a : 0;
  }
}

} // namespace

PictureBlock picture_block(const Shot& shot, const ClassTable& table, const FieldBricks& bricks,
                           KernelForm form) {
  PictureBlock b;
  const Slice& slice = *shot.slice;
  const ShaderKind kind = shader_kind(shot, table, form);
  set_rays(shot, b);
  set_light(shot, kind, form, b);
  set_surfaces(shot, table, b);
  const double radius = kind.kernel.radius, pitch = coset_pitch(kind.bcc);
  b.field = {slice.base, slice.base - slice.air, static_cast<float>(1 / pitch),
             static_cast<float>(-2 * pitch / (radius * radius))};
  b.classes = {table.low, table.scale, static_cast<float>(table.size() - 1), table.unit_distance};
  const TimeField time(slice);
  b.frame = vec4f(time.gradient, time.offset);
  b.counts[3] = table_row;
  set_marks(bricks, b);
  for (size_t a = 0; a < 3; ++a)
    b.first_site[a] = bricks.first_site[a], b.bricks[a] = bricks.bricks[a], b.cells[a] = bricks.cells[a];
  return b;
}

int cells_of_step(const Shot& shot) {
  const SheetView& view = *shot.view;
  double step = 0; // along any ray, lattice units
  for (const double i : {0.0, view.width - 1.0})
    for (const double j : {0.0, view.height - 1.0}) step = std::max(step, length(view.ray(i, j)));
  const double cell = 2 * coset_pitch(shot.slice->lattice.bcc); // of 2^3 sites
  return static_cast<int>(std::ceil(step / cell));
}

std::vector<uint8_t> unseen_by(const Shot& shot, const ClassTable& table, const FieldBricks& bricks) {
  const Slice& slice = *shot.slice;
  const int steps = cells_of_step(shot);
  const bool base_seen = (shot.options.disable_skips & skip_transfer_function) != 0;
  const double base = slice.base;
  switch (shot.options.mode) {
  case RenderMode::composite:
    return unseen_cells(bricks, table.integrals.empty() ? 0 : steps, [&](float low, float high) {
      return base_seen || table.crossed(base + low, base + high);
    });
  case RenderMode::isosurface:
    return unseen_cells(bricks, steps, [&](float low, float high) {
      return base_seen || std::any_of(shot.options.surfaces.begin(), shot.options.surfaces.end(),
                                      [&](const IsoSurface& s) {
                                        return s.value >= base + low && s.value <= base + high;
                                      });
    });
  default: // of a maximum cells of the base alone count by their first sample
    const bool adds_up = shot.options.mode == RenderMode::xray && slice.base != slice.air;
    return unseen_cells(bricks, 0,
                        [&](float low, float high) { return base_seen || adds_up || low < 0 || high > 0; });
  }
}

} // namespace bccsplat
