// SPDX-License-Identifier: Apache-2.0
// Lists what a trail or several instances are made of, as shots of one slice each, with their tables, and
// writes the texels by which the shader knows each.
#include "gpu/object_look.h"

#include <algorithm>

#include "shade/preintegrate.h"

namespace bccsplat {
namespace {

Shot alone(const Shot& shot) {
  Shot out = shot;
  out.trail = nullptr, out.options.mode = RenderMode::composite, out.options.surfaces.clear();
  return out;
}

GpuObject still_object(const Shot& shot, const ShotStill& still) {
  const ShotTrail& trail = *shot.trail;
  const ShotTrail::Source& source = trail.sources[still.shares.front().source];
  GpuObject out{alone(shot), still.weight, 1};
  out.shot.slice = source.slice, out.shot.view = source.view, out.shot.points = nullptr;
  out.shot.function = &trail.functions[still.function], out.shot.table = &trail.tables[still.function];
  return out;
}

} // namespace

std::vector<GpuObject> trail_objects(const Shot& shot, bool with_slice) {
  std::vector<GpuObject> out;
  if (with_slice) out.push_back({alone(shot), 1, 0});
  for (const ShotStill& still : shot.trail->stills) out.push_back(still_object(shot, still));
  return out;
}

std::vector<GpuObject> instance_objects(Shots shots) {
  std::vector<GpuObject> out;
  for (const Shot* shot : shots) out.push_back({*shot});
  return out;
}

std::vector<ClassTable> object_tables(std::span<const GpuObject> objects, std::span<const double> change) {
  std::vector<ClassTable> out;
  bool any = false;
  for (size_t n = 0; n < objects.size(); ++n) {
    out.push_back(gpu_table(objects[n].shot, change[n]));
    any = any || !out.back().integrals.empty();
  }
  for (size_t n = 0; n < objects.size() && any; ++n)
    if (out[n].integrals.empty()) out[n].integrals = integrate_values(*objects[n].shot.function, out[n]);
  return out;
}

KernelForm objects_form(std::span<const GpuObject> objects) {
  const bool flat = std::all_of(objects.begin(), objects.end(),
                                [](const GpuObject& o) { return gpu_form(o.shot) == KernelForm::flat_form; });
  return flat ? KernelForm::flat_form : KernelForm::exact;
}

ShaderKind objects_kind(std::span<const GpuObject> objects, TrailCombine combine,
                        std::span<const ClassTable> tables) {
  ShaderKind kind = shader_kind(objects.front().shot, tables.front(), objects_form(objects));
  for (const ClassTable& t : tables)
    kind.integrals = kind.integrals || !t.integrals.empty(), kind.split = kind.split || t.integrals.split;
  kind.objects = 1;
  while (kind.objects < static_cast<int>(objects.size())) kind.objects *= 2; // so that shaders are few
  kind.combine = combine;
  return kind;
}

std::vector<Vec4f> object_row(const GpuObject& object, const PictureBlock& b, const ObjectPlace& place,
                              int first_row) {
  const auto texel = [](const auto& v, float w) {
    return Vec4f{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), w};
  };
  std::vector<Vec4f> out;
  for (const auto* three : {&b.origin, &b.along, &b.to_world})
    out.insert(out.end(), three->begin(), three->end());
  for (const Vec4f& one : {b.field, b.classes, b.noise, b.frame}) out.push_back(one);
  out.push_back(texel(b.first_site, static_cast<float>(b.counts[0])));
  out.push_back(texel(b.bricks, static_cast<float>(first_row)));
  out.push_back(texel(b.cells, static_cast<float>(object.group)));
  out.push_back(texel(place.bricks, b.centre[2]));
  out.push_back(texel(place.cells, object.share));
  out.insert(out.end(), b.cuts.begin(), b.cuts.end());
  out.resize(object_texels);
  return out;
}

} // namespace bccsplat
