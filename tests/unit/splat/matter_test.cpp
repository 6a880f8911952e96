// SPDX-License-Identifier: Apache-2.0
// The loops of trails, in vectors, against their reference forms, and the law that extinctions add.
#include "splat/sheet/matter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "shade/preintegrate.h"
#include "tests/support/larger.h"

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
    Sheet samples; // by the values at the sheet alone the peak is missed or hit by chance
    samples.table = reference.table;
    reference_matter_loops().absorb(samples.args(shading), 0.3f, samples.group(1));
    double off = 0;
    for (size_t i = 0; i < samples.matter.size(); ++i)
      off = larger(off, std::fabs(samples.matter[i] - reference.matter[i]));
    EXPECT_GT(off, 0.1);
    EXPECT_TRUE(std::isfinite(off));
  }
}

TEST(Matter, JoiningIsTheSameInVectors) {
  for (const TrailCombine combine : {TrailCombine::physical, TrailCombine::interleaved})
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

// Equation (8) of Neophytou & Mueller 2002 in numbers: behind an opacity of 1/2, a slice of opacity 1/2 and
// red 0.8, and a trail of 3/4 and 0.4. As printed, c += (1 - a)(c1 a1 + c2 a2) / 2 and a += (1 - a)(a1 + a2)
// / 2; physically 1 - 1/2 1/4 is shared by optical depths 1 : 2.
TEST(Matter, SliceAndTrailAreJoinedByTheEquation) {
  struct Case {
    TrailCombine combine;
    double alpha, red;
  };
  const double mean = (0.8 + 2 * 0.4) / 3;
  for (const Case& c : {Case{TrailCombine::interleaved, 0.5 + 0.5 * 0.625, 0.2 + 0.5 * (0.4 + 0.3) / 2},
                        Case{TrailCombine::physical, 0.5 + 0.5 * 0.875, 0.2 + 0.5 * 0.875 * mean}})
    for (const MatterLoops* loops : {&reference_matter_loops(), &simd_matter_loops()}) {
      Sheet s;
      const size_t pixels = size_t{Sheet::pitch} * Sheet::height;
      const float depths[] = {std::log(2.0f), std::log(4.0f)}, reds[] = {0.8f, 0.4f};
      const MatterPlanes groups[] = {s.group(0), s.group(1)};
      JoinArgs j;
      j.k = 5, j.width = Sheet::width, j.height = Sheet::height, j.pitch = Sheet::pitch;
      for (size_t g = 0; g < 2; ++g) {
        std::fill_n(groups[g].depth, pixels, depths[g]);
        std::fill_n(groups[g].red, pixels, depths[g] * reds[g]);
        j.group[g] = &groups[g];
      }
      j.combine = c.combine, j.stop = 1, j.pixel = s.planes();
      std::fill_n(j.pixel.alpha, pixels, 0.5f), std::fill_n(j.pixel.red, pixels, 0.2f);
      (void)loops->join(j);
      for (int x = 0; x < Sheet::width; ++x) {
        ASSERT_NEAR(j.pixel.alpha[x], c.alpha, 1e-6);
        ASSERT_NEAR(j.pixel.red[x], c.red, 1e-6);
      }
    }
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
