// SPDX-License-Identifier: Apache-2.0
// Labels that a host names as such: of any number and type, whole wherever they are looked up, and refused
// where they could not be.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support.h"

namespace host {
namespace {

constexpr std::array<float, 8> numbers{0, 2, 4, 1035, 0.1F, 0.25F, 100001, 3e7F};
double block(double x, double y, double z, double t) {
  return numbers[static_cast<size_t>((x + t) / 4 + y / 5 + z / 6) % numbers.size()];
}

class SaidLabels : public testing::Test {
 protected:
  SaidLabels() {
    channel.set_mask = BCCSPLAT_CHANNEL_LABELS;
    series.nx = 20, series.ny = 16, series.nz = 12, series.nt = 4;
    series.field = block;
    options = options_of(series);
    options.lattice = BCCSPLAT_LATTICE_CC;
    options.channels = &channel, options.channel_count = 1;
  }
  void write() {
    volume.reset(); // Windows replaces no file that is open
    const Writer w = make_writer(device, folder.file("l.bcc4"), options);
    EXPECT_OK(add_frames(w.get(), series, 0));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    volume = open(device, folder.file("l.bcc4"));
  }
  [[nodiscard]] bccsplat_status created() const {
    bccsplat_writer* made = nullptr;
    const bccsplat_status status =
        bccsplat_writer_create(device.get(), folder.file("x.bcc4").c_str(), &options, &made);
    bccsplat_writer_release(made);
    return status;
  }
  [[nodiscard]] bool are_labels() const {
    auto info = sized<bccsplat_channel_info>();
    EXPECT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &info));
    return info.labels != 0;
  }
  [[nodiscard]] float value(std::array<double, 4> at) const {
    float found = 0;
    EXPECT_OK(bccsplat_volume_evaluate(volume.get(), 1, at.data(), &found, nullptr));
    return found;
  }

  Folder folder;
  Device device = make_device();
  Volume volume;
  Series series;
  bccsplat_channel_options channel = sized<bccsplat_channel_options>();
  bccsplat_writer_options options{};
};

TEST_F(SaidLabels, AreThoseOfTheNearestSample) {
  options.faces = BCCSPLAT_FACES_PREDICT,
  options.ends = BCCSPLAT_ENDS_PREDICT; // sites before the first sample
  write();
  EXPECT_TRUE(are_labels());
  // Slices of one moment, and across an axis: u, v, w are what is left of x, y, z, t.
  for (const size_t axis : {3u, 0u, 2u}) {
    SCOPED_TRACE(axis);
    const std::array<double, 4> at{5.2, 7.4, 6.6, 1.5};
    auto plane = sized<bccsplat_hyperplane>();
    (axis == 3 ? plane.d : axis == 2 ? plane.c : plane.a) = 1, plane.e = -at[axis];
    bccsplat_slice* made = nullptr;
    ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, nullptr, &made));
    const Slice slice(made);
    for (double first = 0.1; first < 11; first += 0.7)
      for (double second = 0.3; second < 11; second += 0.9) {
        std::array<double, 4> p = at;
        p[axis == 0 ? 1 : 0] = first, p[axis == 2 ? 1 : 2] = second;
        std::array<double, 3> uvw{};
        for (size_t a = 0, k = 0; a < 4; ++a)
          if (a != axis) uvw[k++] = p[a];
        std::array<double, 4> sample{};
        for (size_t a = 0; a < 4; ++a) sample[a] = std::floor(p[a] + 0.5);
        const auto nearest = static_cast<float>(block(sample[0], sample[1], sample[2], sample[3]));
        EXPECT_EQ(value(p), nearest) << first << ' ' << second;
        float found = 0;
        ASSERT_OK(bccsplat_slice_evaluate(made, 1, uvw.data(), &found, nullptr));
        EXPECT_EQ(found, nearest) << first << ' ' << second;
      }
  }
}

// Places that are computed miss half way by rounding: points and slices are of one mind there.
TEST_F(SaidLabels, HalfWayAreThoseOfTheLaterSample) {
  constexpr double rounding = 1e-12;
  write();
  bccsplat_slice* made = nullptr;
  for (const double moment : {1.5, 1.5 - rounding}) {
    auto plane = sized<bccsplat_hyperplane>();
    plane.d = 1, plane.e = -moment;
    ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, nullptr, &made));
    const Slice slice(made);
    for (double x = 0.5; x < 19; x += 1)
      for (const double by : {0.0, -rounding, -1e-6}) {
        const std::array<double, 4> at{x + by, 4.5 + by, 5.5 + by, moment};
        const double later = by < -1e-9 ? 0 : 1;
        const auto nearest = static_cast<float>(block(std::floor(x) + later, 4 + later, 5 + later, 2));
        float found = 0;
        ASSERT_OK(bccsplat_slice_evaluate(made, 1, at.data(), &found, nullptr));
        EXPECT_EQ(found, nearest) << x << ' ' << by;
        EXPECT_EQ(value(at), nearest) << x << ' ' << by;
      }
  }
}

TEST_F(SaidLabels, OfATurnAreThoseOfItsFirstSampleAgain) {
  options.periodic_axes = BCCSPLAT_PERIODIC_X;
  write();
  EXPECT_EQ(value({19.7, 5, 5, 1}), static_cast<float>(block(0, 5, 5, 1)));
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -1;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, nullptr, &made));
  const Slice slice(made);
  const std::array<double, 3> uvw{19.7, 5, 5};
  float found = 0;
  ASSERT_OK(bccsplat_slice_evaluate(made, 1, uvw.data(), &found, nullptr));
  EXPECT_EQ(found, static_cast<float>(block(0, 5, 5, 1)));
}

// Along uneven axes, too, where slices for pictures are of even positions.
class UnevenLabels : public SaidLabels {
 protected:
  UnevenLabels() {
    for (size_t a = 0; a < 3; ++a) {
      axes[a] = sized<bccsplat_axis>();
      if (a == 1) continue;
      const double last = a == 0 ? 19 : 11;
      for (double i = 0; i <= last; ++i) places[a].push_back((i + 0.05 * i * i) / (1 + 0.05 * last));
      axes[a].coordinates = places[a].data(), axes[a].count = places[a].size();
    }
    options.axes = axes.data();
    for (size_t a = 0; a < 4; ++a) options.affine[5 * a] = 1; // even positions are the coordinates
  }
  [[nodiscard]] Slice cut_evenly(size_t axis, double at, const double* box = nullptr) const {
    auto plane = sized<bccsplat_hyperplane>();
    (axis == 3 ? plane.d : axis == 2 ? plane.c : plane.a) = 1, plane.e = -at;
    auto o = sized<bccsplat_slice_options>();
    o.space = BCCSPLAT_SPACE_EVEN, o.box = box;
    bccsplat_slice* made = nullptr;
    EXPECT_OK(bccsplat_slice_create(volume.get(), &plane, &o, &made));
    return Slice(made);
  }
  // The place of an index along an axis, which is its even position.
  [[nodiscard]] double even_of(size_t axis, double index) const {
    std::array<double, 3> at{};
    at[axis] = index;
    EXPECT_OK(bccsplat_volume_index_to_world(volume.get(), 1, at.data(), at.data()));
    return at[axis];
  }

  std::array<std::vector<double>, 3> places;
  std::array<bccsplat_axis, 3> axes{};
};

TEST_F(UnevenLabels, OfEvenPositionsAreThoseOfTheNearestSample) {
  write();
  const double box[6] = {even_of(0, 4.2), 3.3, even_of(2, 1.7), even_of(0, 15.4), 12.6, even_of(2, 9.9)};
  const Slice whole = cut_evenly(3, 1.4), part = cut_evenly(3, 1.4, box),
              across = cut_evenly(0, even_of(0, 6.4));
  for (double x = 4.3; x < 15; x += 0.29)
    for (double z = 1.8; z < 9.8; z += 0.33) {
      const std::array<double, 3> at{even_of(0, x), 7.3, even_of(2, z)}, over_time{7.3, even_of(2, z), 1.4};
      const auto label = [&](double i) { return static_cast<float>(block(i, 7, std::floor(z + 0.5), 1)); };
      float found = 0;
      for (const Slice* slice : {&whole, &part}) {
        ASSERT_OK(bccsplat_slice_evaluate(slice->get(), 1, at.data(), &found, nullptr));
        ASSERT_EQ(found, label(std::floor(x + 0.5))) << x << ' ' << z << (slice == &part ? " of a box" : "");
      }
      ASSERT_OK(bccsplat_slice_evaluate(across.get(), 1, over_time.data(), &found, nullptr));
      ASSERT_EQ(found, label(6)) << z << " across x";
    }
}

TEST_F(UnevenLabels, PicturesMixNoColours) {
  constexpr uint32_t pixels = 64;
  series.field = [](double x, double, double, double) { return x < 8 ? 3 : 7; };
  write();
  const Slice slice = cut_evenly(3, 1.4);
  // Green is what is no label.
  constexpr std::array<double, 24> colors{2.5, 1, 0, 0, 3.4, 1, 0, 0, 3.5, 0, 1, 0,
                                          6.5, 0, 1, 0, 6.6, 0, 0, 1, 7.5, 0, 0, 1};
  constexpr std::array<double, 4> opacities{3, 0.2, 7, 0.2};
  auto f = sized<bccsplat_transfer_function>();
  f.colors = colors.data(), f.color_count = 6, f.opacities = opacities.data(), f.opacity_count = 2;
  f.unit_distance = 1;
  bccsplat_renderer* made = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &made));
  const Renderer renderer(made);
  auto look = sized<bccsplat_render_options>();
  look.mode = BCCSPLAT_MODE_COMPOSITE, look.shading = BCCSPLAT_SHADING_OFF;
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_slice_fit_camera(slice.get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 20, 30, pixels, pixels,
                                      &camera));
  ASSERT_OK(bccsplat_renderer_set_slice(made, slice.get()));
  ASSERT_OK(bccsplat_renderer_set_camera(made, &camera));
  ASSERT_OK(bccsplat_renderer_set_options(made, &look));
  ASSERT_OK(bccsplat_renderer_set_transfer_function(made, &f));
  std::vector<float> rgba(size_t{4} * pixels * pixels);
  bccsplat_frame* wrapped = nullptr;
  ASSERT_OK(bccsplat_frame_wrap(device.get(), pixels, pixels, rgba.data(), 0, &wrapped));
  const Frame frame(wrapped);
  ASSERT_OK(bccsplat_renderer_render(made, wrapped));
  std::array<double, 3> sum{};
  for (size_t n = 0; n < rgba.size(); ++n)
    if (n % 4 < 3) sum[n % 4] += static_cast<double>(rgba[n]);
  EXPECT_GT(sum[0], 10);
  EXPECT_GT(sum[2], 10);
  EXPECT_LT(sum[1], 1e-3 * (sum[0] + sum[2]));
}

TEST_F(SaidLabels, QuantitiesOfFewWholeNumbersAreBlended) {
  series.field = [](double x, double, double, double) { return x < 10 ? 3 : 7; };
  channel.source_type = channel.value_type = BCCSPLAT_TYPE_U8;
  channel.set_mask = 0;
  write();
  EXPECT_TRUE(are_labels()) << "by its values, where nobody says it";
  channel.set_mask = BCCSPLAT_CHANNEL_QUANTITIES, options.overwrite = 1;
  write();
  EXPECT_FALSE(are_labels());
  EXPECT_NEAR(value({9.5, 5, 5, 1}), 5, 0.1);
}

TEST_F(SaidLabels, WhatWouldBlendThemIsRefused) {
  const auto refused = [&](const auto& change, const std::string& why) {
    const bccsplat_writer_options before = options;
    change();
    EXPECT_EQ(created(), BCCSPLAT_ERROR_UNSUPPORTED);
    EXPECT_NE(std::string(bccsplat_last_error()).find(why), std::string::npos) << bccsplat_last_error();
    options = before;
  };
  const std::string whole =
      "labels come back whole from samples of lattice CC at distance 1 alone; store them so";
  refused([&] { options.lattice = BCCSPLAT_LATTICE_D4STAR; }, whole);
  refused([&] { options.scale = 1.5; }, whole);
  refused([&] { options.store = BCCSPLAT_STORE_WAVELETS, options.abs_error = 1; }, whole);
  refused([&] { options.levels = 1; },
          "labels have no means, of which coarser levels are made; store none of these");
  EXPECT_EQ(created(), BCCSPLAT_OK);
  channel.set_mask |= BCCSPLAT_CHANNEL_QUANTITIES;
  EXPECT_EQ(created(), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

// Whether codes have the values is known when the first ones come.
TEST_F(SaidLabels, CodesThatAreOnlyNearAreRefused) {
  const auto first_frame = [&] {
    const Writer w = make_writer(device, folder.file("x.bcc4"), options);
    EXPECT_OK(bccsplat_writer_set_attribute(w.get(), "labels.value", "yes"));
    EXPECT_EQ(bccsplat_writer_set_attribute(w.get(), "labels.value", "no"), BCCSPLAT_ERROR_INVALID_ARGUMENT);
    return add_frames(w.get(), series, 0);
  };
  channel.value_type = BCCSPLAT_TYPE_F16;
  EXPECT_EQ(first_frame(), BCCSPLAT_ERROR_UNSUPPORTED);
  channel.value_type = BCCSPLAT_TYPE_U8, channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE;
  channel.range[1] = 1035;
  EXPECT_EQ(first_frame(), BCCSPLAT_ERROR_UNSUPPORTED);
  series.field = [](double x, double, double, double) { return x < 10 ? 3.5 : 7; };
  channel.range[1] = 7, channel.value_step = 0.5;
  EXPECT_EQ(first_frame(), BCCSPLAT_OK) << "steps that the values come in";
}

TEST_F(SaidLabels, ThatFloatsCannotTellApartAreRefused) {
  std::vector<int32_t> labels(size_t{20} * 16 * 12, 16777216);
  bccsplat_box box{};
  box.struct_size = sizeof box;
  box.dims[0] = 20, box.dims[1] = 16, box.dims[2] = 12;
  box.data = labels.data();
  box.type = BCCSPLAT_TYPE_I32;
  const auto added = [&](int32_t label) {
    labels[999] = label;
    const Writer w = make_writer(device, folder.file("x.bcc4"), options);
    return bccsplat_writer_add_frame(w.get(), 0, 0, &box, 1);
  };
  EXPECT_EQ(added(-16777216), BCCSPLAT_OK);
  EXPECT_EQ(added(16777217), BCCSPLAT_ERROR_LIMIT_EXCEEDED); // 16777216 as a float
  EXPECT_NE(std::string(bccsplat_last_error()).find("further than 16777216 from 0"), std::string::npos);
  EXPECT_EQ(added(-16777217), BCCSPLAT_ERROR_LIMIT_EXCEEDED);
  channel.set_mask |= BCCSPLAT_CHANNEL_SET_AIR, channel.air = 16777214;
  EXPECT_EQ(added(-2), BCCSPLAT_OK);
  EXPECT_EQ(added(-3), BCCSPLAT_ERROR_LIMIT_EXCEEDED);
  channel.set_mask = BCCSPLAT_CHANNEL_QUANTITIES;
  EXPECT_EQ(added(16777217), BCCSPLAT_OK);
}

// A plan keeps what its host says of them, and no file blends them.
TEST_F(SaidLabels, APlanKeepsThem) {
  const auto planned = [&](uint32_t kind) {
    channel.set_mask = kind;
    auto o = sized<bccsplat_plan_options>();
    o.wish = &options;
    o.frame = [](void* user, uint64_t frame, uint32_t, void* values) {
      const Series& s = *static_cast<const Series*>(user);
      auto* to = static_cast<float*>(values);
      for (uint32_t z = 0; z < s.nz; ++z)
        for (uint32_t y = 0; y < s.ny; ++y)
          for (uint32_t x = 0; x < s.nx; ++x)
            *to++ = static_cast<float>(s.field(x, y, z, static_cast<double>(frame)));
      return int32_t{0};
    };
    o.frame_user = &series;
    bccsplat_plan* made = nullptr;
    EXPECT_OK(bccsplat_plan_create(device.get(), &o, &made));
    auto chosen = sized<bccsplat_writer_options>();
    EXPECT_OK(bccsplat_plan_get_writer_options(made, &chosen));
    bccsplat_writer* writer = nullptr;
    const bccsplat_status status =
        bccsplat_writer_create(device.get(), folder.file("p.bcc4").c_str(), &chosen, &writer);
    const std::pair result{
        chosen.channels[0].set_mask & (BCCSPLAT_CHANNEL_LABELS | BCCSPLAT_CHANNEL_QUANTITIES), status};
    bccsplat_writer_release(writer);
    bccsplat_plan_release(made);
    return result;
  };
  options.lattice = BCCSPLAT_LATTICE_DEFAULT;
  using Result = std::pair<uint32_t, bccsplat_status>;
  EXPECT_EQ(planned(BCCSPLAT_CHANNEL_QUANTITIES), Result(BCCSPLAT_CHANNEL_QUANTITIES, BCCSPLAT_OK));
  series.field = [](double x, double y, double, double t) { return std::sin(0.3 * x + 0.2 * y + t); };
  EXPECT_EQ(planned(0), Result(0, BCCSPLAT_OK)) << "off the grid of the source there are none";
  EXPECT_EQ(planned(BCCSPLAT_CHANNEL_LABELS), Result(BCCSPLAT_CHANNEL_LABELS, BCCSPLAT_OK));
  options.lattice = BCCSPLAT_LATTICE_D4STAR;
  EXPECT_EQ(planned(BCCSPLAT_CHANNEL_LABELS), Result(BCCSPLAT_CHANNEL_LABELS, BCCSPLAT_ERROR_UNSUPPORTED));
}

// Files whose writer does not name them may have levels, which are means of them.
TEST_F(SaidLabels, LevelsThatAreThereAreNotShown) {
  series.field = [](double x, double, double, double) { return x < 9 ? 3 : 7; };
  channel.source_type = channel.value_type = BCCSPLAT_TYPE_U8;
  channel.set_mask = 0, options.levels = 1;
  write();
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -1;
  auto o = sized<bccsplat_slice_options>();
  o.level = 1;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, &o, &made));
  const Slice slice(made);
  for (double x = 0; x < 19; x += 0.3) {
    const std::array<double, 3> uvw{x, 5, 5};
    float found = 0;
    ASSERT_OK(bccsplat_slice_evaluate(made, 1, uvw.data(), &found, nullptr));
    EXPECT_EQ(found, x < 8.5 ? 3 : 7) << x;
  }
  o.level = 2;
  bccsplat_slice* none = nullptr;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &plane, &o, &none), BCCSPLAT_ERROR_NOT_FOUND);
  constexpr uint32_t small = 8;
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_slice_fit_camera(made, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 20, 30, small, small, &camera));
  auto needs = sized<bccsplat_picture_needs>();
  ASSERT_OK(bccsplat_slice_get_picture_needs(made, &camera, small, small, nullptr, &needs));
  EXPECT_EQ(needs.level, 0u);
}

} // namespace
} // namespace host
