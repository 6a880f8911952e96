// SPDX-License-Identifier: Apache-2.0
// The loops of trails, in vectors, against their reference forms, and the law that extinctions add.
#include "splat/trail/matter.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "shade/preintegrate.h"

namespace bccsplat {
namespace {

// A tile of random rays, values, opacities and matter; both forms of a loop work on copies of it.
struct Sheet {
  static constexpr int width = 37, height = 5, pitch = 48, plane_pitch = 80, margin = 40;
  std::vector<float> rays, pixels, matter, value;
  ClassTable table;
  Lights lights;

  Sheet()
      : rays(6 * pitch * height), pixels(7 * pitch * height), matter(12 * pitch * height),
        value(plane_pitch * (height + 2) + 2 * margin) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (float& v : value) v = uniform(random);
    for (float& m : matter) m = uniform(random) < 0.3f ? 0 : uniform(random);
    for (size_t p = 0; p < size_t{pitch} * height; ++p) {
      const bool inside = p % pitch < width;
      rays[p] = inside ? 4.4f + uniform(random) : 1e30f;                   // enter
      rays[p + pitch * height] = inside ? 4.8f + uniform(random) : -1e30f; // leave
      rays[p + 2 * pitch * height] = 0.5f + uniform(random);               // path
      rays[p + 5 * pitch * height] = 1;                                    // to the viewer: z
      pixels[p + 3 * pitch * height] = uniform(random) < 0.2f ? 0.999f : 0.9f * uniform(random);
    }
    for (int i = 0; i < 64; ++i) {
      const float x = static_cast<float>(i) / 63;
      table.entry.push_back({x, 1 - x, 0.5f, i < 10 ? 0.0f : x});
    }
    table.scale = 63;
    index_visible(table);
  }
  PixelPlanes planes() {
    const size_t n = size_t{pitch} * height;
    PixelPlanes p;
    float** const own[] = {&p.red, &p.green, &p.blue, &p.alpha, &p.depth, &p.value, &p.time};
    for (size_t i = 0; i < 7; ++i) *own[i] = pixels.data() + i * n;
    const float** const ray[] = {&p.enter, &p.leave, &p.path, &p.view_x, &p.view_y, &p.view_z};
    for (size_t i = 0; i < 6; ++i) *ray[i] = rays.data() + i * n;
    return p;
  }
  // Of a sheet whose gradients are differences over one neighbour.
  SheetArgs args(bool shading) {
    const float* const v = value.data() + plane_pitch + margin;
    return {.segment = {.k = 5},
            .tile = {.width = width, .height = height, .pitch = pitch, .plane_pitch = plane_pitch},
            .field = {.value = v},
            .differences = {.neighbours = 1, .before = v, .after = v},
            .basis = {.x = {1, 0, 0}, .y = {0, 1, 0}, .z = {0, 0, 1}},
            .classes = {.table = &table, .stop = 0.995f},
            .shading = {.on = shading, .lights = &lights},
            .time = {3, 0.25f, -0.5f, 0},
            .pixel = planes()};
  }
  MatterPlanes group(size_t g) {
    const size_t n = size_t{pitch} * height;
    float* at = matter.data() + g * 6 * n;
    return {at, at + n, at + 2 * n, at + 3 * n, at + 4 * n, at + 5 * n};
  }
};

void expect_near(const std::vector<float>& a, const std::vector<float>& b, float tolerance) {
  for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], tolerance * (1 + std::fabs(b[i]))) << i;
}

TEST(Matter, AbsorbingIsTheSameInVectors) {
  for (const auto& [shading, noise] : {std::pair(false, 0.0), {true, 0.0}, {true, 0.1}}) {
    Sheet reference, vectors;
    for (Sheet* s : {&reference, &vectors}) {
      s->lights.noise = {noise, noise};
      SheetArgs a = s->args(shading);
      a.shading.noise = a.shading.noise_of_value = static_cast<float>(noise);
      (s == &reference ? reference_matter_loops() : simd_matter_loops()).absorb(a, 0.3f, s->group(1));
    }
    expect_near(vectors.matter, reference.matter, 1e-5f);
    EXPECT_NE(reference.matter, Sheet().matter);
  }
}

// By the integrals of a function with a step and a peak, each narrower than what sheets differ by.
TEST(Matter, AbsorbingByIntegralsIsTheSameInVectors) {
  TransferFunction function;
  function.colors = {{0, {1, 0.2, 0.1}}, {1, {0.1, 0.4, 1}}};
  function.opacities = {{0.2, 0}, {0.2, 0.3}, {0.4, 0}, {0.69, 0}, {0.7, 0.9}, {0.71, 0}};
  for (const bool shading : {false, true}) {
    Sheet reference, vectors;
    for (Sheet* s : {&reference, &vectors}) {
      s->table = make_class_table(function, 0, 1, 0, 1, 64);
      s->table.integrals = integrate_values(function, s->table);
      SheetArgs a = s->args(shading);
      const float* const v = a.field.value;
      a.halves = {.preintegrated = true,
                  .known = 100,
                  .front = {{v, v + 3, v - 2, v + 5}, {0.5f, 0.5f, 0, 0}},
                  .back = {{v, v - 1, v + 7, v}, {0.5625f, 0.5f, -0.0625f, 0}}};
      (s == &reference ? reference_matter_loops() : simd_matter_loops()).absorb(a, 0.3f, s->group(1));
    }
    expect_near(vectors.matter, reference.matter, 1e-4f);
    EXPECT_NE(reference.matter, Sheet().matter);
  }
}

TEST(Matter, JoiningIsTheSameInVectors) {
  for (const TrailCombine combine :
       {TrailCombine::physical, TrailCombine::interleaved, TrailCombine::interleaved_consistent})
    for (const unsigned groups : {1u, 2u, 3u}) {
      Sheet reference, vectors;
      int closed[2];
      for (Sheet* s : {&reference, &vectors}) {
        const MatterPlanes a = s->group(0), b = s->group(1);
        JoinArgs j;
        j.k = 5, j.width = Sheet::width, j.height = Sheet::height, j.pitch = Sheet::pitch;
        j.group = {groups & 1 ? &a : nullptr, groups & 2 ? &b : nullptr};
        j.combine = combine, j.stop = 0.995f, j.pixel = s->planes();
        closed[s == &vectors] = (s == &reference ? reference_matter_loops() : simd_matter_loops()).join(j);
      }
      EXPECT_EQ(closed[0], closed[1]);
      // Beside the tile vectors may leave anything.
      for (Sheet* s : {&reference, &vectors})
        for (size_t p = 0; p < s->pixels.size(); ++p)
          if (p % Sheet::pitch >= Sheet::width) s->pixels[p] = 0;
      expect_near(vectors.pixels, reference.pixels, 2e-5f);
    }
}

// A lone object is composited as its own opacity: 1 - exp(-depth), whatever the shares of the sheet.
TEST(Matter, ExtinctionsAdd) {
  Sheet s;
  std::fill(s.pixels.begin(), s.pixels.end(), 0.0f);
  const MatterPlanes a = s.group(0), b = s.group(1);
  JoinArgs j;
  j.k = 5, j.width = Sheet::width, j.height = Sheet::height, j.pitch = Sheet::pitch;
  j.group = {&a, &b}, j.stop = 2, j.pixel = s.planes();
  (void)simd_matter_loops().join(j);
  for (int x = 0; x < Sheet::width; ++x)
    EXPECT_NEAR(j.pixel.alpha[x], 1 - std::exp(-(a.depth[x] + b.depth[x])), 1e-6);
}

TEST(Matter, MixingIsTheSameInVectors) {
  Sheet s;
  const std::vector<const float*> from{s.value.data(), s.value.data() + 3, s.value.data() + 7};
  const std::vector<float> weight{0.5f, -0.25f, 2};
  std::vector<float> out[2];
  std::array<float, 2> range[2];
  for (int form = 0; form < 2; ++form) {
    out[form].resize(s.value.size());
    range[form] = (form ? simd_matter_loops() : reference_matter_loops())
                      .mix({from, weight, out[form].data(), Sheet::width, Sheet::height, Sheet::plane_pitch});
  }
  for (int y = 0; y < Sheet::height; ++y)
    for (int x = 0; x < Sheet::width; ++x) {
      const size_t p = y * Sheet::plane_pitch + x;
      EXPECT_NEAR(out[1][p], out[0][p], 1e-6);
      EXPECT_NEAR(out[0][p], 0.5f * s.value[p] - 0.25f * s.value[p + 3] + 2 * s.value[p + 7], 1e-6);
    }
  EXPECT_LE(range[1][0], range[0][0] + 1e-6f); // whole vectors: at least as wide
  EXPECT_GE(range[1][1], range[0][1] - 1e-6f);
}

} // namespace
} // namespace bccsplat
