// SPDX-License-Identifier: Apache-2.0
// Waves are summed row by row, by turning a phase; what else fills a series is a function of the place and of
// that sum.
#include "tests/bench/moments/moments_content.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace bccsplat::bench {
namespace {

constexpr double turn = 2 * std::numbers::pi;

struct Wave {
  double x, y, z, t, phase; // radians a voxel or frame
};

// Waves of `shortest` voxels to `longest`, as many of one octave as of another where `octaves` is set.
std::vector<Wave> make_waves(int count, double shortest, double longest, bool octaves) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Wave> made;
  for (int i = 0; i < count; ++i) {
    Wave w{unit(random), unit(random), unit(random), unit(random), 3 * unit(random)};
    const double length = std::sqrt(w.x * w.x + w.y * w.y + w.z * w.z + w.t * w.t);
    const double at = std::fabs(unit(random));
    const double wave =
        octaves ? shortest * std::pow(longest / shortest, at) : shortest + (longest - shortest) * at;
    const double scale = turn / wave / length;
    w.x *= scale, w.y *= scale, w.z *= scale, w.t *= scale;
    made.push_back(w);
  }
  return made;
}

// Adds a wave at time t to n^3 values: a product of turns along the axes, two multiplications a voxel.
void add_wave(const Wave& w, double t, size_t n, std::vector<float>& sum) {
  const double c = std::cos(w.x), s = std::sin(w.x);
  for (size_t z = 0; z < n; ++z)
    for (size_t y = 0; y < n; ++y) {
      const double start = w.y * static_cast<double>(y) + w.z * static_cast<double>(z) + w.t * t + w.phase;
      double re = std::cos(start), im = std::sin(start);
      float* row = sum.data() + (z * n + y) * n;
      for (size_t x = 0; x < n; ++x) {
        row[x] += static_cast<float>(re);
        const double next = re * c - im * s;
        im = re * s + im * c, re = next;
      }
    }
}

std::vector<float> sum_of(const std::vector<Wave>& waves, double t, size_t n) {
  std::vector<float> sum(n * n * n);
  for (const Wave& w : waves) add_wave(w, t, n, sum);
  return sum;
}

using Point = std::array<double, 3>; // of [-1, 1]^3

// Replaces each value by what a function of it and of its place makes of it.
void for_each(std::vector<float>& values, size_t n, const std::function<double(double, const Point&)>& make) {
  const auto place = [&](size_t i) { return 2 * static_cast<double>(i) / static_cast<double>(n - 1) - 1; };
  for (size_t z = 0; z < n; ++z)
    for (size_t y = 0; y < n; ++y)
      for (size_t x = 0; x < n; ++x) {
        float& value = values[(z * n + y) * n + x];
        value = static_cast<float>(make(value, {place(x), place(y), place(z)}));
      }
}

double radius_of(const Point& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

// The field of Marschner and Lobb (1994), its rings wandering with time.
double marschner_lobb(const Point& p, double t) {
  constexpr double frequency = 6, amplitude = 0.25;
  const double r = std::hypot(p[0], p[1]);
  const double ripple = std::cos(turn * frequency * std::cos(0.5 * std::numbers::pi * r) + 0.1 * t);
  return (1 - std::sin(0.5 * std::numbers::pi * p[2]) + amplitude * (1 + ripple)) / (2 * (1 + amplitude));
}

// A value that is 1 at a distance of 0 and falls like a bell of that half width, in voxels.
double bell(double distance, double width) {
  return std::exp(-std::numbers::ln2 * distance * distance / (width * width));
}

const std::vector<Wave>& plain_waves() {
  static const std::vector<Wave> waves = make_waves(12, 8, 60, false);
  return waves;
}
constexpr double wave_middle = 128, wave_height = 14;

} // namespace

double waves_at(const Vec3& p, double t, Vec3* gradient) {
  double value = wave_middle;
  if (gradient) *gradient = {};
  for (const Wave& w : plain_waves()) {
    const Vec3 k{w.x, w.y, w.z};
    const double phase = dot(k, p) + w.t * t + w.phase;
    value += wave_height * std::cos(phase);
    if (gradient) *gradient = *gradient - (wave_height * std::sin(phase)) * k;
  }
  return value;
}

std::string name_of(Content content) {
  constexpr std::array names{"waves", "Marschner-Lobb", "turbulence", "thin shells", "a vessel"};
  return names[static_cast<size_t>(content)];
}

std::vector<float> content_values(Content content, size_t n, double t) {
  static const std::vector<Wave> swirls = make_waves(60, 6, 120, true);
  std::vector<float> values = sum_of(content == Content::turbulence ? swirls : plain_waves(), t, n);
  const double half = 0.5 * static_cast<double>(n - 1); // voxels
  for_each(values, n, [&](double wave, const Point& p) {
    switch (content) {
    case Content::waves:
      return wave_middle + wave_height * wave;
    case Content::marschner_lobb:
      return 255 * marschner_lobb(p, t);
    case Content::turbulence:
      return 300 * std::fabs(wave) / 12;
    case Content::thin_shells: {
      const double r = radius_of(p) * half + 0.3 * t, gap = 24;
      return 40 + 180 * bell(std::remainder(r, gap), 1) + 2 * wave;
    }
    case Content::vessel: {
      const double x = p[0] - 0.4 * std::sin(4 * p[2] + 0.05 * t), y = p[1] - 0.4 * std::cos(3 * p[2]);
      return 60 + 4 * wave + 170 * bell(std::hypot(x, y) * half, 0.7);
    }
    }
    return 0.0;
  });
  return values;
}

} // namespace bccsplat::bench
