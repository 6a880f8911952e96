// SPDX-License-Identifier: Apache-2.0
// Samples a slice at its own resolution, classifies it, takes means at half of that, and follows light
// through them.
#include "scene/kept_light.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "field/sample_grid.h"
#include "view/view.h"

namespace bccsplat {
namespace {

// Samples from node to node along each axis.
constexpr int coarser = 2;

// The nodes of a slice's domain, and the samples that their extinctions are means of.
struct Nodes {
  LightGrid grid; // lattice units
  Grid samples;   // slice space: `coarser` times as fine, from the first node to the last
};

Nodes nodes_of(const Slice& slice) {
  Nodes out;
  const DrawnBox box = drawn_box(slice);
  const Vec3 across = samples_across(slice);
  for (size_t a = 0; a < 3; ++a) {
    const auto steps = static_cast<int>(std::max(std::ceil((across[a] - 1) / coarser), 1.0));
    out.grid.begin[a] = box.begin[a], out.grid.step[a] = (box.end[a] - box.begin[a]) / steps;
    out.grid.nodes[a] = steps + 1;
    out.samples.dims[a] = coarser * steps + 1;
    const double to_slice = slice.lattice_to_slice.linear[a][a];
    out.samples.origin[a] = slice.lattice_to_slice.offset[a] + to_slice * out.grid.begin[a];
    out.samples.step[a] = to_slice * out.grid.step[a] / coarser;
  }
  return out;
}

bool cut_off(const std::vector<HalfSpace>& clip, const Vec3& p) {
  return std::any_of(clip.begin(), clip.end(),
                     [&](const HalfSpace& h) { return dot(h.normal, p) + h.offset < 0; });
}

// Replaces values by extinctions, those of what is missing or cut off by none.
void classify(std::span<float> values, const Grid& samples, const Shot& shot, const Context& context) {
  const Affine3 to_lattice = shot.slice->lattice_to_slice.inverse();
  const auto nx = static_cast<size_t>(samples.dims[0]), ny = static_cast<size_t>(samples.dims[1]);
  context.tasks.parallel_for(values.size() / nx, [&](uint64_t number_of_row) {
    context.progress.check();
    const auto row = static_cast<size_t>(number_of_row);
    for (size_t x = 0; x < nx; ++x) {
      float& value = values[row * nx + x];
      const std::array<size_t, 3> number{x, row % ny, row / ny};
      Vec3 p;
      for (size_t a = 0; a < 3; ++a)
        p[a] = samples.origin[a] + samples.step[a] * static_cast<double>(number[a]);
      const bool none = std::isnan(value) || cut_off(shot.view->clip, to_lattice.point(p));
      value = none ? 0 : shot.table->entry[static_cast<size_t>(shot.table->index(value))][3];
    }
  });
}

// Takes the mean around every second sample of an axis, by 1/4, 1/2 and 1/4; at the ends of what is there.
std::vector<float> halve(std::span<const float> in, Int3& dims, size_t axis) {
  Int3 half = dims;
  half[axis] = (dims[axis] - 1) / coarser + 1;
  const auto count = [](const Int3& n, size_t a) { return static_cast<size_t>(n[a]); };
  size_t stride = 1, outer = 1;
  for (size_t a = 0; a < axis; ++a) stride *= count(dims, a);
  for (size_t a = axis + 1; a < 3; ++a) outer *= count(dims, a);
  std::vector<float> out(stride * outer * count(half, axis));
  for (size_t o = 0; o < outer; ++o)
    for (size_t n = 0; n < count(half, axis); ++n)
      for (size_t i = 0; i < stride; ++i) {
        const float* const at = in.data() + (o * count(dims, axis) + coarser * n) * stride + i;
        const float before = n > 0 ? at[-static_cast<std::ptrdiff_t>(stride)] : at[stride];
        const float behind = n + 1 < count(half, axis) ? at[stride] : before;
        out[(o * count(half, axis) + n) * stride + i] = std::midpoint(at[0], std::midpoint(before, behind));
      }
  dims = half;
  return out;
}

std::vector<float> extinctions(const Nodes& nodes, const Shot& shot, const Context& context) {
  Int3 dims = nodes.samples.dims;
  std::vector<float> all(static_cast<size_t>(dims[0]) * static_cast<size_t>(dims[1]) *
                         static_cast<size_t>(dims[2]));
  sample_grid(*shot.slice, nodes.samples, all.data(), context);
  classify(all, nodes.samples, shot, context);
  for (size_t axis = 0; axis < 3; ++axis) all = halve(all, dims, axis);
  return all;
}

LightWay way_of(const Shot& shot, const Vec3& towards) {
  return {towards, length(shot.view->lattice_to_world.vector(towards))};
}

std::vector<float> ambient_through(const LightGrid& grid, std::span<const float> extinction, const Shot& shot,
                                   const Context& context) {
  const Affine3 to_lattice = shot.view->lattice_to_world.inverse();
  std::vector<float> sum(grid.size(), 0.0f);
  for (const WayAround& way : all_around()) {
    const std::vector<float> one =
        light_through(grid, extinction, way_of(shot, to_lattice.vector(way.direction)), context);
    for (size_t n = 0; n < sum.size(); ++n) sum[n] += static_cast<float>(way.weight) * one[n];
  }
  return sum;
}

} // namespace

KeptLight::Key KeptLight::key_of(const Shot& shot) {
  const SheetView& view = *shot.view;
  const Affine3 to_lattice = view.lattice_to_world.inverse();
  Key key{shot.slice, view.lattice_to_world, shot.table->entry, shot.table->low, shot.table->scale, view.clip,
          {},         shot.lights->occlusion};
  // A light at the camera is taken to shine along the ray of the middle of the whole picture.
  const Vec3 from_camera = -1.0 * view.middle;
  if (shot.lights->shadow)
    for (const Light& light : shot.lights->lights)
      key.towards.push_back(dot(light.direction, light.direction) > 0 ? to_lattice.vector(light.direction)
                                                                      : from_camera);
  return key;
}

std::shared_ptr<const LightVolume> KeptLight::of(const Shot& shot, const Context& context) {
  Key key = key_of(shot);
  if (kept_ && key == key_) return kept_;
  forget();
  shot.slice->coset.make(context);
  const Nodes nodes = nodes_of(*shot.slice);
  const size_t planes = key.towards.size() + (key.occlusion ? 1 : 0);
  constexpr size_t at_work = coarser * coarser * coarser + 3; // samples, columns, and a plane that is made
  Reservation memory(context.memory, LightVolume::bytes_of(nodes.grid, planes), "the light of a picture");
  const Reservation work(context.memory, LightVolume::bytes_of(nodes.grid, at_work),
                         "making the light of a picture");
  const std::vector<float> extinction = extinctions(nodes, shot, context);
  std::vector<std::vector<float>> lights;
  for (const Vec3& towards : key.towards)
    lights.push_back(light_through(nodes.grid, extinction, way_of(shot, towards), context));
  std::vector<float> ambient;
  if (key.occlusion) ambient = ambient_through(nodes.grid, extinction, shot, context);
  kept_ = std::make_shared<const LightVolume>(nodes.grid, std::move(lights), std::move(ambient),
                                              std::move(memory));
  key_ = std::move(key);
  return kept_;
}

} // namespace bccsplat
