// SPDX-License-Identifier: Apache-2.0
// A slice as bricks: against the slice's own values, its sites by the formula of the header, and by a host
// that marches through an atlas of them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "support.h"

namespace host {
namespace {

using Point = std::array<double, 3>;

struct Bricks {
  bccsplat_brick_options options = sized<bccsplat_brick_options>();
  bccsplat_brick_info info = sized<bccsplat_brick_info>();
  std::vector<uint32_t> index;
  std::vector<std::array<float, 2>> bounds;
  uint64_t count = 0;
  std::vector<uint32_t> cells; // of all bricks, listed or not
  std::vector<std::byte> values;
  std::vector<std::array<float, 2>> ranges;

  Bricks(const Slice& slice, const bccsplat_brick_options& o) : options(o) {
    EXPECT_OK(bccsplat_slice_get_brick_info(slice.get(), &options, &info));
    index.resize(size_t{info.cosets} * info.bricks[0] * info.bricks[1] * info.bricks[2]);
    bounds.resize(index.size()), ranges.resize(index.size());
    EXPECT_OK(bccsplat_slice_find_bricks(slice.get(), &options, index.data(), bounds.data()->data(), &count));
    for (uint32_t n = 0; n < index.size(); ++n) cells.push_back(n);
    values.resize(cells.size() * info.brick_bytes);
    EXPECT_OK(bccsplat_slice_get_bricks(slice.get(), &options, cells.size(), cells.data(), values.data(),
                                        ranges.data()->data()));
  }

  [[nodiscard]] size_t samples() const { return size_t{info.edge} * info.edge * info.edge; }
  template<class T = float> [[nodiscard]] T at(size_t cell, size_t sample) const {
    T v;
    std::memcpy(&v, values.data() + cell * info.brick_bytes + sample * sizeof(T), sizeof(T));
    return v;
  }
  // Calls body(cell, sample of the brick, sample of the grid) for all samples of all bricks.
  template<class Body> void each(const Body& body) const {
    const auto edge = static_cast<int64_t>(info.edge), border = static_cast<int64_t>(options.border),
               own = edge - 2 * border;
    for (size_t cell = 0; cell < index.size(); ++cell) {
      std::array<int64_t, 3> first{};
      for (size_t a = 0, rest = cell; a < 3; rest /= info.bricks[a++])
        first[a] = static_cast<int64_t>(rest % info.bricks[a]) * own - border;
      for (int64_t z = 0, n = 0; z < edge; ++z)
        for (int64_t y = 0; y < edge; ++y)
          for (int64_t x = 0; x < edge; ++x, ++n)
            body(cell, static_cast<size_t>(n),
                 std::array<int64_t, 3>{first[0] + x, first[1] + y, first[2] + z});
    }
  }
  // Slice space of a sample; beyond the last one that of the last.
  [[nodiscard]] Point place(std::array<int64_t, 3> sample) const {
    Point p{};
    for (size_t a = 0; a < 3; ++a) {
      const auto last = static_cast<int64_t>(info.dims[a]) - 1;
      p[a] = info.origin[0][a] + info.step[a] * static_cast<double>(std::clamp<int64_t>(sample[a], 0, last));
    }
    return p;
  }
};

bccsplat_brick_options bricks_of(uint32_t edge, uint32_t border, double spacing = 0) {
  auto o = sized<bccsplat_brick_options>();
  o.edge = edge, o.border = border, o.spacing = spacing;
  return o;
}

std::vector<float> evaluate(const Slice& slice, const std::vector<Point>& points) {
  std::vector<float> values(points.size());
  (void)bccsplat_slice_evaluate(slice.get(), points.size(), points.data()->data(), values.data(), nullptr);
  return values;
}

// All samples are those that the slice has there, within `off`, and within the bounds; bricks that are not
// listed hold what is empty. Returns how many samples are NaN.
size_t check_samples(const Slice& slice, const Bricks& b, double off) {
  std::vector<Point> points;
  b.each([&](size_t, size_t, const auto& sample) { points.push_back(b.place(sample)); });
  const std::vector<float> there = evaluate(slice, points);
  size_t n = 0, missing = 0, wrong = 0;
  b.each([&](size_t cell, size_t sample, const auto&) {
    const float v = b.at(cell, sample), of_slice = there[n++];
    missing += std::isnan(v);
    const bool same = std::isnan(v) ? std::isnan(of_slice) : std::fabs(v - of_slice) <= off;
    const bool within = std::isnan(v) || (v >= b.bounds[cell][0] && v <= b.bounds[cell][1]);
    const bool listed = b.index[cell] != 0 || std::isnan(v) || v == static_cast<float>(b.info.empty);
    wrong += !(same && within && listed);
  });
  EXPECT_EQ(wrong, 0u);
  uint32_t next = 0;
  for (size_t cell = 0; cell < b.index.size(); ++cell) {
    if (b.index[cell] != 0) {
      EXPECT_EQ(b.index[cell], ++next);
    }
    if (std::isnan(b.ranges[cell][0])) continue;
    EXPECT_GE(b.ranges[cell][0], b.bounds[cell][0]);
    EXPECT_LE(b.ranges[cell][1], b.bounds[cell][1]);
  }
  EXPECT_EQ(next, b.count);
  return missing;
}

class BricksOfSlices : public testing::Test {
 protected:
  Volume write(const Series& s, const std::function<void(bccsplat_writer_options&)>& change = {}) {
    auto o = options_of(s);
    if (change) change(o);
    const std::string path = folder.file(std::to_string(++files) + ".bcc4");
    const Writer w = make_writer(device, path, o);
    EXPECT_OK(add_frames(w.get(), s));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    return open(device, path);
  }
  Folder folder;
  Device device = make_device();
  int files = 0;
};

// A ball in much air.
Series small_ball() {
  Series s;
  s.nx = 61, s.ny = 40, s.nz = 37, s.nt = 4;
  s.field = [](double x, double y, double z, double t) {
    const double r = std::hypot(x - 20 - 2 * t, y - 18, z - 17) / 11;
    return r < 1 ? 100 * std::pow(1 - r * r, 3) : 0;
  };
  return s;
}

TEST_F(BricksOfSlices, HoldTheFieldWithBordersAndBounds) {
  const Volume volume = write(small_ball());
  const Slice slice = cut_time(volume, 1.4);
  for (const auto& o : {bricks_of(8, 2), bricks_of(0, 1), bricks_of(16, 0, 0.7), bricks_of(9, 16, 2.5)}) {
    SCOPED_TRACE(std::to_string(o.edge) + " " + std::to_string(o.border) + " " + std::to_string(o.spacing));
    const Bricks b(slice, o);
    EXPECT_EQ(b.info.edge, (o.edge ? o.edge : 32) + 2 * o.border);
    EXPECT_EQ(b.info.brick_bytes, b.samples() * sizeof(float));
    EXPECT_EQ(check_samples(slice, b, 1e-4), 0u);
    EXPECT_GT(b.count, 0u);
    // The first and the last sample stand at the ends.
    const Point last = b.place({100000, 100000, 100000});
    EXPECT_NEAR(last[0], 60, 1e-9);
    EXPECT_NEAR(last[1], 39, 1e-9);
    EXPECT_NEAR(last[2], 36, 1e-9);
    for (const double step : b.info.step) EXPECT_LE(step, o.spacing == 0 ? 1 : o.spacing);
  }
  const Bricks b(slice, bricks_of(8, 1));
  EXPECT_LT(3 * b.count, 2 * b.index.size()) << "much of it is air";
  EXPECT_EQ(b.info.empty, 0);
}

TEST_F(BricksOfSlices, AreOfAnyHyperplane) {
  const Volume volume = write(small_ball());
  EXPECT_EQ(
      check_samples(cut(volume, 1, 0, 0, 0, -9.3), {cut(volume, 1, 0, 0, 0, -9.3), bricks_of(8, 1)}, 1e-4),
      0u);
  const Slice oblique = cut(volume, 1, 2, 0.5, 3, -40);
  EXPECT_GT(check_samples(oblique, {oblique, bricks_of(8, 1)}, 1e-4), 0u) << "corners lie outside";
  const Slice nothing = cut(volume, 1, 0, 0, 0, 5000);
  const Bricks none(nothing, bricks_of(8, 1));
  EXPECT_EQ(none.index.size(), 0u);
  EXPECT_EQ(none.count, 0u);
  auto box = sized<bccsplat_slice_options>();
  const std::array<double, 6> corners{3, 4.5, 2, 21, 17, 12.25};
  box.box = corners.data();
  bccsplat_slice* part = nullptr;
  ASSERT_OK(bccsplat_volume_slice_at(volume.get(), 1, &box, &part));
  const Slice boxed(part);
  EXPECT_EQ(check_samples(boxed, {boxed, bricks_of(8, 1)}, 1e-4), 0u);
}

TEST_F(BricksOfSlices, HoldWhatIsMissingAndCorrected) {
  Series s = small_ball();
  s.field = [](double x, double y, double z, double t) {
    return std::hypot(x - 10, y - 12) < 3 ? NAN : 5 + blob(x, y, z, t) + 20 * std::sin(2.5 * x);
  };
  const Volume volume = write(s, [](bccsplat_writer_options& o) {
    o.nonfinite = BCCSPLAT_NONFINITE_HOLE, o.abs_error = 0.5, o.scale = 1.2;
  });
  const Slice slice = cut_time(volume, 2);
  EXPECT_GT(check_samples(slice, {slice, bricks_of(8, 1, 0.5)}, 2e-4), 1000u);
  auto bytes = bricks_of(8, 1);
  bytes.type = BCCSPLAT_TYPE_U8;
  const Bricks coded(slice, bytes), exact(slice, bricks_of(8, 1));
  const double of_nothing =
      std::clamp(std::round((exact.info.empty - coded.info.offset) / coded.info.scale), 0.0, 255.0);
  exact.each([&](size_t cell, size_t sample, const auto&) {
    if (std::isnan(exact.at(cell, sample))) {
      ASSERT_EQ(coded.at<uint8_t>(cell, sample), of_nothing);
    }
  });
}

TEST_F(BricksOfSlices, AreCodedAsAsked) {
  const Volume volume = write(small_ball());
  const Slice slice = cut_time(volume, 1.4);
  const Bricks exact(slice, bricks_of(8, 1));
  const auto check = [&](auto zero, bccsplat_type type, double low, double high) {
    using Code = decltype(zero);
    SCOPED_TRACE(type);
    auto o = bricks_of(8, 1);
    o.type = type, o.range[0] = low, o.range[1] = high;
    const Bricks b(slice, o);
    ASSERT_EQ(b.info.brick_bytes, b.samples() * sizeof(Code));
    if (low < high) {
      EXPECT_EQ(b.info.offset, low);
    }
    const double top = b.info.offset + b.info.scale * std::numeric_limits<Code>::max();
    EXPECT_NEAR(top, low < high ? high : top, 1e-4);
    double worst = 0;
    exact.each([&](size_t cell, size_t sample, const auto&) {
      const double value = b.info.offset + b.info.scale * b.at<Code>(cell, sample);
      worst =
          std::max(worst, std::fabs(value - std::clamp<double>(exact.at(cell, sample), b.info.offset, top)));
    });
    EXPECT_LE(worst, 0.5001 * b.info.scale);
    EXPECT_GT(worst, 0.3 * b.info.scale);
    EXPECT_EQ(b.ranges, exact.ranges) << "before they are coded";
  };
  check(uint8_t{}, BCCSPLAT_TYPE_U8, 0, 0);
  check(uint8_t{}, BCCSPLAT_TYPE_U8, 10, 60);
  check(uint16_t{}, BCCSPLAT_TYPE_U16, 0, 0);
  check(uint16_t{}, BCCSPLAT_TYPE_U16, -5, 400);
  auto half = bricks_of(8, 1);
  half.type = BCCSPLAT_TYPE_F16;
  const Bricks b(slice, half);
  exact.each([&](size_t cell, size_t sample, const auto&) {
    const uint16_t h = b.at<uint16_t>(cell, sample);
    const double value = std::ldexp(1 + (h & 1023) / 1024.0, (h >> 10 & 31) - 15);
    const double there = exact.at(cell, sample);
    if (there > 1e-3) {
      ASSERT_NEAR(value, there, there / 2048);
    }
  });
}

// The field at a point of slice space by the formula of bccsplat_brick_grid.
double by_sites(const Bricks& b, const Point& p) {
  const auto border = static_cast<int64_t>(b.options.border), edge = static_cast<int64_t>(b.info.edge),
             own = edge - 2 * border;
  double sum = 0, weights = 0;
  const size_t per_coset = b.index.size() / b.info.cosets;
  for (size_t c = 0; c < b.info.cosets; ++c) {
    Point at{};
    std::array<int64_t, 3> brick{};
    for (size_t a = 0; a < 3; ++a) {
      at[a] = (p[a] - b.info.origin[c][a]) / b.info.step[a];
      const auto nearest = static_cast<int64_t>(std::floor(at[a]));
      brick[a] = std::clamp<int64_t>(nearest / own, 0, int64_t{b.info.bricks[a]} - 1);
    }
    const size_t cell =
        c * per_coset +
        static_cast<size_t>((brick[2] * b.info.bricks[1] + brick[1]) * b.info.bricks[0] + brick[0]);
    int64_t n = 0;
    for (int64_t z = 0; z < edge; ++z)
      for (int64_t y = 0; y < edge; ++y)
        for (int64_t x = 0; x < edge; ++x, ++n) {
          const std::array<int64_t, 3> site{x, y, z};
          double r2 = 0;
          for (size_t a = 0; a < 3; ++a) {
            const double d = at[a] - static_cast<double>(brick[a] * own - border + site[a]);
            r2 += d * d;
          }
          const double u = std::max(0.0, 1 - r2 / (b.info.kernel_radius * b.info.kernel_radius));
          double phi = 0;
          for (uint32_t j = b.info.kernel_terms; j-- > 0;) phi = phi * u + b.info.kernel[j];
          if (u <= 0) continue;
          sum += phi * (b.at(cell, static_cast<size_t>(n)) - b.info.empty), weights += phi;
        }
  }
  return b.info.empty + (b.info.kernel_normalised ? sum / weights : sum);
}

TEST_F(BricksOfSlices, SitesGiveTheFieldByTheFormula) {
  struct Case {
    const char* name;
    const char* kernel;
    double off;
    std::function<void(bccsplat_writer_options&)> change;
  };
  const std::array<Case, 5> cases{{
      {"D4*", nullptr, 1e-3, {}},
      {"Cartesian", nullptr, 1e-3, [](bccsplat_writer_options& o) { o.lattice = BCCSPLAT_LATTICE_CC; }},
      {"the paper's kernel", "paper", 0.1, {}},
      {"mirrored faces", "fine", 1e-3, [](bccsplat_writer_options& o) { o.faces = BCCSPLAT_FACES_MIRROR; }},
      {"periodic along x", nullptr, 1e-3,
       [](bccsplat_writer_options& o) { o.periodic_axes = BCCSPLAT_PERIODIC_X; }},
  }};
  Series s;
  s.nx = 24, s.ny = 19, s.nz = 17, s.nt = 3;
  s.field = [](double x, double y, double z, double) {
    return 50 + 30 * std::sin(M_PI * x / 12) * std::cos(0.3 * y) + z;
  };
  std::mt19937 random(5);
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Volume volume = write(s, c.change);
    if (c.kernel) volume = open(device, folder.file(std::to_string(files) + ".bcc4"), c.kernel);
    const Slice slice = cut_time(volume, 0.7);
    auto o = bricks_of(8, 3);
    o.grid = BCCSPLAT_BRICK_GRID_SITES;
    const Bricks b(slice, o);
    ASSERT_LE(b.info.kernel_radius, 3);
    auto info = sized<bccsplat_slice_info>();
    ASSERT_OK(bccsplat_slice_get_info(slice.get(), &info));
    EXPECT_EQ(b.info.cosets, info.lattice == BCCSPLAT_LATTICE_BCC ? 2u : 1u);
    std::vector<Point> points;
    for (int n = 0; n < 300; ++n) {
      Point p{};
      for (size_t a = 0; a < 3; ++a)
        p[a] = std::uniform_real_distribution<double>(info.extent[a][0], info.extent[a][1])(random);
      if (n % 3 == 0) p[static_cast<size_t>(n / 3 % 3)] = info.extent[n / 3 % 3][n % 2];
      points.push_back(p);
    }
    const std::vector<float> there = evaluate(slice, points);
    for (size_t n = 0; n < points.size(); ++n) ASSERT_NEAR(by_sites(b, points[n]), there[n], c.off) << n;
    for (size_t cell = 0; cell < b.bounds.size(); ++cell) EXPECT_LE(b.bounds[cell][0], b.ranges[cell][0]);
  }
}

TEST_F(BricksOfSlices, HoldLabelsAsTheyAre) {
  Series s;
  s.nx = 30, s.ny = 21, s.nz = 18, s.nt = 2;
  s.field = [](double x, double y, double, double) { return x < 12.5 ? 0 : y < 9.5 ? 3 : 7; };
  auto channel = sized<bccsplat_channel_options>();
  channel.source_type = channel.value_type = BCCSPLAT_TYPE_U8;
  const Volume volume = write(s, [&](bccsplat_writer_options& o) {
    o.lattice = BCCSPLAT_LATTICE_CC, o.channels = &channel, o.channel_count = 1;
  });
  const Slice slice = cut_time(volume, 0);
  const Bricks b(slice, bricks_of(4, 1, 0.5));
  EXPECT_EQ(check_samples(slice, b, 0), 0u);
  EXPECT_LT(b.count, b.index.size());
  EXPECT_GT(b.count, b.index.size() / 3);
  auto sites = bricks_of(4, 1);
  sites.grid = BCCSPLAT_BRICK_GRID_SITES;
  auto info = sized<bccsplat_brick_info>();
  EXPECT_EQ(bccsplat_slice_get_brick_info(slice.get(), &sites, &info), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(bccsplat_last_error()).find("labels"), std::string::npos);
}

// What a host's GPU does: an atlas of bricks that hold data, a texture of their numbers, linear filters.
class Atlas {
 public:
  Atlas(const Slice& slice, const bccsplat_brick_options& o) : options_(o) {
    EXPECT_OK(bccsplat_slice_get_brick_info(slice.get(), &o, &info_));
    index_.resize(size_t{info_.bricks[0]} * info_.bricks[1] * info_.bricks[2]);
    uint64_t count = 0;
    EXPECT_OK(bccsplat_slice_find_bricks(slice.get(), &o, index_.data(), nullptr, &count));
    std::vector<uint32_t> cells;
    for (uint32_t n = 0; n < index_.size(); ++n)
      if (index_[n] != 0) cells.push_back(n);
    EXPECT_EQ(cells.size(), count);
    bricks_.resize(count * info_.brick_bytes / sizeof(uint16_t));
    EXPECT_OK(bccsplat_slice_get_bricks(slice.get(), &o, count, cells.data(), bricks_.data(), nullptr));
  }
  [[nodiscard]] double sample(const Point& uvw) const {
    const size_t own = info_.edge - 2 * options_.border, edge = info_.edge;
    size_t cell = 0, first = 0;
    Point part{};
    for (size_t a = 3; a-- > 0;) {
      const double at = (uvw[a] - info_.origin[0][a]) / info_.step[a];
      const auto i = static_cast<size_t>(std::clamp(at, 0.0, static_cast<double>(info_.dims[a] - 1)));
      cell = cell * info_.bricks[a] + i / own, first = first * edge + i % own + options_.border;
      part[a] = at - static_cast<double>(i);
    }
    if (index_[cell] == 0) return info_.empty;
    const uint16_t* const brick = bricks_.data() + (index_[cell] - 1) * edge * edge * edge + first;
    double code = 0;
    for (size_t n = 0; n < 8; ++n)
      code += ((n & 1) ? part[0] : 1 - part[0]) * ((n & 2) ? part[1] : 1 - part[1]) *
              ((n & 4) ? part[2] : 1 - part[2]) *
              brick[(n & 1) + (n >> 1 & 1) * edge + (n >> 2) * edge * edge];
    return info_.offset + info_.scale * code;
  }

 private:
  bccsplat_brick_options options_;
  bccsplat_brick_info info_ = sized<bccsplat_brick_info>();
  std::vector<uint32_t> index_;
  std::vector<uint16_t> bricks_;
};

TEST_F(BricksOfSlices, MarchedByAHostGiveThePicture) {
  Series s = small_ball();
  s.field = [](double x, double y, double z, double t) {
    return blob(x - 20, y - 8, z - 8, t) * (1 + 0.3 * std::sin(0.9 * x) * std::cos(0.8 * y + 0.5 * z));
  };
  const Volume volume = write(s);
  const Slice slice = cut_time(volume, 1.4);
  constexpr uint32_t width = 122, height = 80; // two pixels a sample
  const std::array<double, 12> colors{0, 0.1, 0.2, 0.9, 60, 0.9, 0.5, 0.1, 120, 1, 1, 0.8};
  const std::array<double, 6> opacities{5, 0, 50, 0.04, 120, 0.5};
  const auto piecewise = [](const auto& table, size_t stride, size_t part, double v) {
    const size_t n = table.size() / stride;
    v = std::clamp(v, table[0], table[(n - 1) * stride]);
    size_t i = 0;
    while (i + 2 < n && v > table[(i + 1) * stride]) ++i;
    const double f = (v - table[i * stride]) / (table[(i + 1) * stride] - table[i * stride]);
    return (1 - f) * table[i * stride + part] + f * table[(i + 1) * stride + part];
  };

  bccsplat_renderer* made = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &made));
  const Renderer renderer(made);
  auto camera = sized<bccsplat_camera>();
  camera.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, camera.ortho_height = height / 2.0;
  camera.position[0] = camera.target[0] = 30, camera.position[1] = camera.target[1] = 19.5;
  camera.position[2] = 300, camera.up[1] = 1; // against z: x to the right
  auto look = sized<bccsplat_transfer_function>();
  look.colors = colors.data(), look.color_count = 3;
  look.opacities = opacities.data(), look.opacity_count = 3, look.unit_distance = 1;
  auto options = sized<bccsplat_render_options>();
  options.shading = BCCSPLAT_SHADING_OFF, options.opacity_stop = 1, options.quality = BCCSPLAT_QUALITY_FINE;
  ASSERT_OK(bccsplat_renderer_set_slice(made, slice.get()));
  ASSERT_OK(bccsplat_renderer_set_camera(made, &camera));
  ASSERT_OK(bccsplat_renderer_set_transfer_function(made, &look));
  ASSERT_OK(bccsplat_renderer_set_options(made, &options));
  std::vector<float> rgba(size_t{4} * width * height);
  bccsplat_frame* wrapped = nullptr;
  ASSERT_OK(bccsplat_frame_wrap(device.get(), width, height, rgba.data(), 0, &wrapped));
  const Frame frame(wrapped);
  ASSERT_OK(bccsplat_renderer_render(made, wrapped));

  const auto decibels = [&](double spacing) {
    auto o = bricks_of(16, 1, spacing);
    o.type = BCCSPLAT_TYPE_U16;
    const Atlas atlas(slice, o);
    double squares = 0;
    for (uint32_t j = 0; j < height; ++j)
      for (uint32_t i = 0; i < width; ++i) {
        std::array<double, 4> pixel{};
        constexpr double step = 0.1;
        for (double z = 36 - step / 2; z > 0; z -= step) {
          const Point p{30 + (i + 0.5 - width / 2.0) / 2, 19.5 - (j + 0.5 - height / 2.0) / 2, z};
          if (p[0] < 0 || p[0] > 60 || p[1] < 0 || p[1] > 39) continue;
          const double v = atlas.sample(p);
          const double opacity = 1 - std::pow(1 - piecewise(opacities, 2, 1, v), step);
          for (size_t c = 0; c < 3; ++c)
            pixel[c] += (1 - pixel[3]) * opacity * piecewise(colors, 4, c + 1, v);
          pixel[3] += (1 - pixel[3]) * opacity;
        }
        for (size_t c = 0; c < 4; ++c)
          squares += std::pow(pixel[c] - rgba[4 * (size_t{j} * width + i) + c], 2);
      }
    return -10 * std::log10(squares / (4.0 * width * height));
  };
  const double half = decibels(0.5);
  EXPECT_GT(half, 45);
  RecordProperty("dB", std::to_string(half));
  EXPECT_LT(decibels(4), 35) << "what is sampled coarsely is another picture";
}

} // namespace
} // namespace host
