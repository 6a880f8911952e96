// SPDX-License-Identifier: Apache-2.0
// The whole chain under symmetries: what is done to the source is done to the result.
#include "tests/stability/stability.h"

namespace host {
namespace {

// No symmetry of its own.
double lopsided(double x, double y, double z, double t) {
  const auto bump = [](double r2, double width) { return std::exp(-r2 / width); };
  const auto square = [](double v) { return v * v; };
  return 60 * bump(square(x - 7 - 0.4 * t) + square(y - 9) + square(z - 11), 16) +
         40 * bump(square(x - 12) + square(y - 6 + 0.3 * t) + square(z - 5), 22);
}

const Series source{.nx = 19, .ny = 19, .nz = 19, .nt = 11, .field = lopsided};

using Map = std::array<double, 4> (*)(double, double, double, double);

// Values of a source seen through `map` at mapped points against the source's own.
void expect_same(const char* name, Map map, double tolerance) {
  const Device device = make_device();
  Series moved = source;
  moved.field = [map](double x, double y, double z, double t) {
    const auto q = map(x, y, z, t);
    return lopsided(q[0], q[1], q[2], q[3]);
  };
  const Stored a = store(device, source), b = store(device, moved);
  const std::vector<double> points = random_points(source, 500);
  std::vector<double> mapped;
  for (size_t i = 0; i < points.size(); i += 4) {
    const auto q = map(points[i], points[i + 1], points[i + 2], points[i + 3]);
    mapped.insert(mapped.end(), q.begin(), q.end());
  }
  Bound(name, tolerance).add(largest_difference(values_at(b.volume, points), values_at(a.volume, mapped)));
}

// The lattice maps onto itself and so do its mirror planes: only rounding may differ. The values reach 70.
constexpr double rounding = 3e-4;

TEST(Metamorphic, ReversingTimeReversesTheResult) {
  // Layers stand sqrt1/2 frames apart from frame 0 on and need not meet the last frame: the field is sampled
  // at other places when time runs backwards, and differs by the kernel's error on it, most where the motion
  // stops at an end.
  expect_same(
      "10 - t, values 0 to 70",
      [](double x, double y, double z, double t) {
        return std::array{x, y, z, 10 - t};
      },
      0.9);
}

TEST(Metamorphic, SwappingAxesSwapsThem) {
  expect_same(
      "y x z",
      [](double x, double y, double z, double t) {
        return std::array{y, x, z, t};
      },
      rounding);
  expect_same(
      "z x y",
      [](double x, double y, double z, double t) {
        return std::array{z, x, y, t};
      },
      rounding);
}

TEST(Metamorphic, AQuarterTurnTurns) {
  expect_same(
      "-y x z",
      [](double x, double y, double z, double t) {
        return std::array{18 - y, x, z, t};
      },
      rounding);
}

TEST(Metamorphic, MirroringMirrors) {
  expect_same(
      "-x y -z",
      [](double x, double y, double z, double t) {
        return std::array{18 - x, y, 18 - z, t};
      },
      rounding);
}

TEST(Metamorphic, AffineChangesOfValueCommute) {
  const Device device = make_device();
  Series moved = source;
  moved.field = [](double x, double y, double z, double t) { return 3 - 2.5 * lopsided(x, y, z, t); };
  auto channel = sized<bccsplat_channel_options>();
  channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
  channel.air = 3;
  bccsplat_writer_options o = options_of(moved);
  o.channels = &channel, o.channel_count = 1;
  const Stored a = store(device, source), b = store(device, moved, o);
  const std::vector<double> points = random_points(source, 500);
  std::vector<float> expected = values_at(a.volume, points);
  for (float& v : expected) v = 3 - 2.5f * v;
  Bound("3 - 2.5 f", 1e-3).add(largest_difference(values_at(b.volume, points), expected));
}

TEST(Metamorphic, SumsOfFieldsAreSumsOfResults) {
  const Device device = make_device();
  const Field other = [](double x, double y, double z, double t) {
    return 20 *
           std::exp(-((x - 9) * (x - 9) + (y - 12) * (y - 12) + (z - 8) * (z - 8) + (t - 5) * (t - 5)) / 20);
  };
  Series one = source, two = source, both = source;
  two.field = other;
  both.field = [&](double x, double y, double z, double t) {
    return lopsided(x, y, z, t) + other(x, y, z, t);
  };
  // Relevance is no linear thing: without a threshold nothing is left out.
  const std::vector<double> points = random_points(source, 500);
  const auto values = [&](const Series& s) { return values_at(store(device, s).volume, points); };
  const std::vector<float> a = values(one), b = values(two), sum = values(both);
  Bound bound("f + g, values 0 to 90", 0.02);
  for (size_t i = 0; i < sum.size(); ++i) bound.add(static_cast<double>(sum[i]) - a[i] - b[i]);
}

TEST(Metamorphic, TurningWorldAndCameraTogetherLeavesThePicture) {
  const Device device = make_device();
  std::vector<float> first;
  // World turned by 90 degrees about z, exactly.
  const double turned[16] = {0, -1, 0, 18, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  for (const bool turn : {false, true}) {
    bccsplat_writer_options o = options_of(source);
    if (turn) std::copy_n(turned, 16, o.affine);
    const Stored stored = store(device, source, o);
    const Slice slice = cut_time(stored.volume, 4.4);
    auto camera = sized<bccsplat_camera>();
    camera.projection = BCCSPLAT_PROJECTION_PERSPECTIVE;
    camera.fovy_degrees = 40;
    const double position[] = {-20, 3, -25}, target[] = {9, 9, 9}, up[] = {0, 1, 0};
    for (int i = 0; i < 3; ++i)
      camera.position[i] = position[i], camera.target[i] = target[i], camera.up[i] = up[i];
    if (turn) {
      const auto turn_point = [](double* p, double offset) {
        const double x = p[0];
        p[0] = offset - p[1], p[1] = x;
      };
      turn_point(camera.position, 18), turn_point(camera.target, 18), turn_point(camera.up, 0);
    }
    const std::vector<float> got =
        picture(device, slice, {.width = 60, .height = 60, .ramp = {5, 70, 0.3, 1}, .camera = &camera});
    if (first.empty())
      first = got;
    else
      Bound("picture, world and camera turned", 2e-4).add(largest_difference(first, got));
  }
}

TEST(Metamorphic, ShiftingByALatticePeriodShifts) {
  // sqrt2 T along an axis is a period of the lattice before it is stretched to the domain; the domain's ends
  // move with the shift, so only the kernel's accuracy on this smooth field is asked for.
  const Device device = make_device();
  Series moved = source;
  moved.nx = 22;
  moved.field = [](double x, double y, double z, double t) { return lopsided(x - 3, y, z, t); };
  const Stored a = store(device, source), b = store(device, moved);
  std::vector<double> points = random_points(source, 500), shifted = points;
  for (size_t i = 0; i < shifted.size(); i += 4) shifted[i] += 3;
  Bound("shifted by 3 samples, values 0 to 70", 0.35)
      .add(largest_difference(values_at(b.volume, shifted), values_at(a.volume, points)));
}

// Half a turn of a periodic axis is a whole number of planes of one coset: the seam of either series is
// inside the other, and pictures of it are the same but for their edges, where one ends.
TEST(Metamorphic, RollingAPeriodicAxisRollsThePicture) {
  constexpr double turn = 48, half = turn / 2;
  constexpr size_t width = 96, height = 40, bytes = 4;
  const Device device = make_device();
  std::vector<std::vector<float>> pictures, grids;
  for (const double roll : {0.0, half}) {
    const Series s{
        .nx = 48, .ny = 18, .nz = 16, .nt = 6, .field = [roll](double x, double y, double z, double t) {
          const double dx = std::remainder(x - 1.3 - 0.3 * t - 0.2 * y - roll, turn);
          return 20 + 100 * std::exp(-(dx * dx + std::pow(y - 9, 2) + std::pow(z - 8, 2)) / 18) +
                 10 * std::sin(2 * M_PI * (x - roll) / turn + 0.2 * y);
        }};
    bccsplat_writer_options o = options_of(s);
    o.lattice = BCCSPLAT_LATTICE_D4STAR, o.periodic_axes = BCCSPLAT_PERIODIC_X;
    const Stored stored = store(device, s, o);
    const Slice slice = cut_time(stored.volume, 2.4);
    auto camera = sized<bccsplat_camera>();
    camera.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
    for (double* p : {camera.position, camera.target}) p[0] = half, p[1] = 9;
    camera.position[2] = -60, camera.target[2] = 8, camera.up[1] = 1;
    camera.ortho_height = turn * height / width; // two pixels a sample
    Shot shot{.width = width, .height = height, .ramp = {15, 120, 0.2, 1}, .camera = &camera};
    shot.options.quality = BCCSPLAT_QUALITY_BEST;
    pictures.push_back(picture(device, slice, shot));
    auto grid = sized<bccsplat_grid>();
    grid.dims[0] = 30, grid.dims[1] = 8, grid.dims[2] = 8; // across the seam of the other one
    for (size_t a = 0; a < 3; ++a) grid.step[a] = 0.3;
    grid.origin[0] = half - 4.5, grid.origin[1] = 6.1, grid.origin[2] = 5.2;
    grids.emplace_back(size_t{30} * 8 * 8);
    if (roll == 0) { // in two halves, either side of its own seam
      for (const bool behind : {false, true}) {
        auto part = grid;
        part.dims[0] = 15, part.origin[0] = behind ? 0 : turn - 4.5;
        std::vector<float> values(size_t{15} * 8 * 8);
        EXPECT_OK(bccsplat_slice_sample_grid(slice.get(), &part, values.data()));
        for (size_t row = 0; row < 64; ++row)
          std::copy_n(values.begin() + (row * 15), 15, grids.back().begin() + (row * 30 + (behind ? 15 : 0)));
      }
    } else {
      EXPECT_OK(bccsplat_slice_sample_grid(slice.get(), &grid, grids.back().data()));
    }
  }
  Bound("values of a box across the seam, 20 to 130", rounding).add(largest_difference(grids[0], grids[1]));
  Bound rolled("picture rolled back", 1e-4);
  float brightest = 0;
  for (size_t row = 0; row < height; ++row)
    for (size_t x = 0; x < width; ++x) {
      const size_t other = (x + width / 2) % width;
      // Where either ends, the pixel's own ray is half outside.
      if (std::min(x, other) < 1 || std::max(x, other) > width - 2) continue;
      for (size_t i = 0; i < bytes; ++i) {
        const float a = pictures[0][(row * width + x) * bytes + i];
        rolled.add(static_cast<double>(a) - pictures[1][(row * width + other) * bytes + i]);
        brightest = std::max(brightest, a);
      }
    }
  EXPECT_GT(brightest, 0.3f);
}

} // namespace
} // namespace host
