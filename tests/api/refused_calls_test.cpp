// SPDX-License-Identifier: Apache-2.0
// Calls that a writer refuses for their arguments, their order or their values: it answers and is as it was,
// so that the file is the same byte for byte as without them.
#include <array>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

constexpr std::array<uint32_t, 3> n{18, 13, 11};

double whole_field(double x, double y, double z, double t) {
  return std::round(20 + 9 * std::sin(0.4 * x + 0.3 * t) * std::cos(0.35 * y - 0.2 * z));
}

std::vector<float> frame_of(uint32_t t) {
  std::vector<float> values;
  for (uint32_t z = 0; z < n[2]; ++z)
    for (uint32_t y = 0; y < n[1]; ++y)
      for (uint32_t x = 0; x < n[0]; ++x) values.push_back(static_cast<float>(whole_field(x, y, z, t)));
  return values;
}

bccsplat_box box_of(const std::vector<float>& values) {
  auto box = sized<bccsplat_box>();
  box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
  for (size_t a = 0; a < 3; ++a) box.dims[a] = n[a];
  return box;
}

// A writer into memory, and what it is asked in vain.
struct Host {
  Host(const TestDevice& device, const bccsplat_writer_options& options) : o(options) {
    auto stream = sized<bccsplat_write_stream>();
    stream.write_at = write_bytes, stream.user = &bytes;
    EXPECT_EQ(bccsplat_writer_create_stream(device.device, &stream, &o, &writer), BCCSPLAT_OK)
        << bccsplat_last_error();
  }
  ~Host() { bccsplat_writer_release(writer); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  void expect(bccsplat_status got, bccsplat_status wanted, const char* text) {
    EXPECT_EQ(got, wanted) << text << ": " << bccsplat_last_error();
    EXPECT_NE(std::string(bccsplat_last_error()).find(text), std::string::npos) << bccsplat_last_error();
    ++refused;
  }
  // A frame whose box is spoilt; time: of the frame that is due.
  template<class Spoil>
  void refuse_box(double time, bccsplat_status wanted, const char* text, const Spoil& spoil) {
    std::vector<float> values = frame_of(0);
    bccsplat_box box = box_of(values);
    spoil(box, values);
    expect(bccsplat_writer_add_frame(writer, 0, time, &box, 1), wanted, text);
  }
  void refuse_boxes(double time) {
    constexpr auto bad = BCCSPLAT_ERROR_INVALID_ARGUMENT;
    using Values = std::vector<float>;
    refuse_box(time, bad, "type", [](bccsplat_box& b, Values&) { b.type = 0; });
    refuse_box(time, bad, "type", [](bccsplat_box& b, Values&) { b.type = 10; });
    refuse_box(time, bad, "data is NULL", [](bccsplat_box& b, Values&) { b.data = nullptr; });
    refuse_box(time, bad, "do not fit", [](bccsplat_box& b, Values&) { b.begin[1] = 1; });
    refuse_box(time, bad, "do not fit", [](bccsplat_box& b, Values&) { b.dims[2] = 0; });
    refuse_box(time, bad, "strides", [](bccsplat_box& b, Values&) { b.stride_bytes[0] = INT64_MIN; });
    refuse_box(time, BCCSPLAT_ERROR_INVALID_STRUCT_SIZE, "bccsplat_box",
               [](bccsplat_box& b, Values&) { b.struct_size = 0; });
    refuse_box(time, BCCSPLAT_ERROR_NONFINITE_VALUE, "not finite",
               [](bccsplat_box&, Values& v) { v[700] = std::numeric_limits<float>::quiet_NaN(); });
    refuse_box(time, BCCSPLAT_ERROR_LIMIT_EXCEEDED, "from air",
               [](bccsplat_box&, Values& v) { v[9] = 3e38f; });
    expect(bccsplat_writer_add_frame(writer, 0, time, nullptr, 2), bad, "boxes is NULL");
    const bccsplat_box box = sized<bccsplat_box>();
    expect(bccsplat_writer_add_frame(writer, 0, time, &box, uint64_t{1} << 60), bad, "boxes of one frame");
  }
  void refuse_times(double before, double time) {
    constexpr auto bad = BCCSPLAT_ERROR_INVALID_ARGUMENT;
    const std::vector<float> values = frame_of(0);
    const bccsplat_box box = box_of(values);
    for (const double wrong : {std::nan(""), static_cast<double>(INFINITY)})
      expect(bccsplat_writer_add_frame(writer, 0, wrong, &box, 1), bad, "not finite");
    if (before >= 0)
      for (const double wrong : {before, before - 1})
        expect(bccsplat_writer_add_frame(writer, 0, wrong, &box, 1), bad, "does not rise");
    expect(bccsplat_writer_add_frame(writer, 7, time, &box, 1), BCCSPLAT_ERROR_NOT_FOUND, "channel 7");
  }
  // In any state, before the last data.
  void refuse_the_rest() {
    constexpr auto bad = BCCSPLAT_ERROR_INVALID_ARGUMENT;
    expect(bccsplat_writer_set_times(writer, 0, 0), bad, "step");
    expect(bccsplat_writer_set_times(writer, std::nan(""), 1), bad, "finite");
    expect(bccsplat_writer_set_attribute(writer, "", "x"), bad, "empty");
    expect(bccsplat_writer_set_attribute(writer, nullptr, "x"), bad, "key");
    expect(bccsplat_writer_add_source(writer, nullptr, 1, 1), bad, "name");
    expect(bccsplat_writer_add_field(writer, 0, nullptr, nullptr), bad, "field is NULL");
    expect(bccsplat_writer_add_layer(writer, 0, 0, nullptr, 5), bad, "samples");
    auto report = sized<bccsplat_writer_report>();
    report.struct_size = 3;
    expect(bccsplat_writer_finish(writer, &report), BCCSPLAT_ERROR_INVALID_STRUCT_SIZE, "report");
  }
  void refuse_finish(const char* text) {
    expect(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_ERROR_WRONG_STATE, text);
  }

  bccsplat_writer_options o;
  Bytes bytes;
  bccsplat_writer* writer = nullptr;
  int refused = 0;
};

struct CallVariant {
  const char* name;
  bccsplat_writer_options options;
};

std::vector<CallVariant> call_variants() {
  std::vector<CallVariant> list;
  const auto add = [&](const char* name, const auto& change) {
    auto o = sized<bccsplat_writer_options>();
    for (size_t a = 0; a < 3; ++a) o.dims[a] = n[a];
    o.dims[3] = 24;
    change(o);
    list.push_back({name, o});
  };
  add("plain", [](bccsplat_writer_options&) {});
  add("length unknown", [](bccsplat_writer_options& o) { o.dims[3] = 0; });
  add("levels", [](bccsplat_writer_options& o) { o.levels = 1; });
  add("bound", [](bccsplat_writer_options& o) { o.abs_error = 0.1; });
  add("psnr", [](bccsplat_writer_options& o) { o.psnr = 20; });
  add("low-pass", [](bccsplat_writer_options& o) { o.lowpass = 1; });
  add("Cartesian", [](bccsplat_writer_options& o) { o.lattice = BCCSPLAT_LATTICE_CC; });
  return list;
}

TEST(RefusedCalls, LeaveAWriterOfFramesAsItWas) {
  const TestDevice device;
  for (const CallVariant& v : call_variants()) {
    SCOPED_TRACE(v.name);
    const auto write = [&](bool meddled) {
      Host host(device, v.options);
      if (meddled) {
        host.refuse_finish("nothing was added");
        host.refuse_the_rest(), host.refuse_times(-1, 0), host.refuse_boxes(0);
      }
      for (uint32_t t = 0; t < 24; ++t) {
        const std::vector<float> values = frame_of(t);
        const bccsplat_box box = box_of(values);
        EXPECT_EQ(bccsplat_writer_add_frame(host.writer, 0, t, &box, 1), BCCSPLAT_OK)
            << bccsplat_last_error();
        if (!meddled || t == 23) continue;
        host.refuse_the_rest();
        if (t % 4 == 0) host.refuse_times(t, t + 1), host.refuse_boxes(t + 1);
        if (host.o.dims[3] > 0) host.refuse_finish("frames, not 24");
        host.expect(bccsplat_writer_add_layer(host.writer, 0, 0, values.data(), values.size()),
                    BCCSPLAT_ERROR_WRONG_STATE, host.o.dims[3] > 0 ? "do not mix" : "number of frames");
      }
      if (meddled && host.o.dims[3] > 0)
        host.expect(bccsplat_writer_add_frame(host.writer, 0, 24, nullptr, 0), BCCSPLAT_ERROR_WRONG_STATE,
                    "made for 24 frames");
      EXPECT_EQ(bccsplat_writer_finish(host.writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
      EXPECT_EQ(host.refused > 200, meddled) << host.refused;
      return host.bytes;
    };
    EXPECT_EQ(write(true), write(false));
  }
}

// What the first frame settles is settled by the first that is taken: here the type of the source.
TEST(RefusedCalls, TheFirstFrameThatIsTakenSettlesTheType) {
  const TestDevice device;
  auto o = call_variants().front().options;
  o.dims[3] = 3;
  const std::vector<unsigned char> values(size_t{n[0]} * n[1] * n[2], 77);
  const auto write = [&](bool meddled) {
    Host host(device, o);
    if (meddled) {
      host.refuse_boxes(0);
      const double nan = std::nan("");
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F64, box.data = &nan, box.dims[0] = box.dims[1] = box.dims[2] = 1;
      host.expect(bccsplat_writer_add_frame(host.writer, 0, 0, &box, 1), BCCSPLAT_ERROR_NONFINITE_VALUE,
                  "not finite");
      const float broken = INFINITY;
      host.expect(bccsplat_writer_add_layer(host.writer, 0, 0, &broken, 1), BCCSPLAT_ERROR_INVALID_ARGUMENT,
                  "sites");
    }
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_U8, box.data = values.data();
    for (size_t a = 0; a < 3; ++a) box.dims[a] = n[a];
    for (int t = 0; t < 3; ++t) EXPECT_EQ(bccsplat_writer_add_frame(host.writer, 0, t, &box, 1), BCCSPLAT_OK);
    EXPECT_EQ(bccsplat_writer_finish(host.writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
    return host.bytes;
  };
  const Bytes plain = write(false);
  EXPECT_EQ(write(true), plain);
  const OpenVolume volume(device, plain);
  auto info = sized<bccsplat_channel_info>();
  ASSERT_EQ(bccsplat_volume_get_channel_info(volume.volume, 0, &info), BCCSPLAT_OK);
  EXPECT_EQ(info.value_type, BCCSPLAT_TYPE_U8);
}

TEST(RefusedCalls, ChannelsOfAFrameAgree) {
  const TestDevice device;
  std::array<bccsplat_channel_options, 2> channels{sized<bccsplat_channel_options>(),
                                                   sized<bccsplat_channel_options>()};
  channels[0].name = "a", channels[1].name = "b";
  auto o = call_variants().front().options;
  o.channels = channels.data(), o.channel_count = 2, o.dims[3] = 12;
  const auto write = [&](bool meddled) {
    Host host(device, o);
    for (uint32_t t = 0; t < 12; ++t) {
      const std::vector<float> values = frame_of(t);
      const bccsplat_box box = box_of(values);
      EXPECT_EQ(bccsplat_writer_add_frame(host.writer, 0, t, &box, 1), BCCSPLAT_OK);
      if (meddled) {
        host.expect(bccsplat_writer_add_frame(host.writer, 1, t + 0.5, &box, 1),
                    BCCSPLAT_ERROR_INVALID_ARGUMENT, "of another channel");
        host.refuse_finish("frames, not 12");
      }
      EXPECT_EQ(bccsplat_writer_add_frame(host.writer, 1, t, &box, 1), BCCSPLAT_OK);
    }
    EXPECT_EQ(bccsplat_writer_finish(host.writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
    return host.bytes;
  };
  EXPECT_EQ(write(true), write(false));
}

TEST(RefusedCalls, LeaveAWriterOfLayersAsItWas) {
  const TestDevice device;
  auto o = call_variants().front().options;
  o.dims[3] = 9, o.lowpass = 1; // of no use to layers
  const auto write = [&](bool meddled) {
    Host host(device, o);
    auto g = sized<bccsplat_layer_geometry>();
    EXPECT_EQ(bccsplat_writer_get_layer_geometry(host.writer, 0, &g), BCCSPLAT_OK);
    const int64_t layers = g.layer_count;
    for (int64_t m = 0; m < layers; ++m) {
      EXPECT_EQ(bccsplat_writer_get_layer_geometry(host.writer, m, &g), BCCSPLAT_OK);
      const size_t sites = g.dims[0] * g.dims[1] * g.dims[2];
      std::vector<float> values(sites);
      for (size_t i = 0; i < sites; ++i)
        values[i] = 1 + std::sin(0.3f * static_cast<float>(i) + static_cast<float>(m));
      const auto give = [&](int64_t layer, size_t count) {
        return bccsplat_writer_add_layer(host.writer, 0, layer, values.data(), count);
      };
      if (meddled) {
        host.refuse_the_rest();
        host.refuse_finish(m == 0 ? "nothing was added" : "layers");
        host.expect(give(m + 1, sites), BCCSPLAT_ERROR_WRONG_STATE, "is next");
        host.expect(give(m, sites - 1), BCCSPLAT_ERROR_INVALID_ARGUMENT, "sites, not");
        values[5] = std::nanf("");
        host.expect(give(m, sites), BCCSPLAT_ERROR_NONFINITE_VALUE, "not finite");
      }
      values[5] = 1 + std::sin(1.5f + static_cast<float>(m));
      EXPECT_EQ(give(m, sites), BCCSPLAT_OK) << bccsplat_last_error();
      if (meddled)
        host.expect(bccsplat_writer_add_frame(host.writer, 0, 0, nullptr, 0), BCCSPLAT_ERROR_WRONG_STATE,
                    "do not mix");
    }
    if (meddled) {
      const float one = 1;
      host.expect(bccsplat_writer_add_layer(host.writer, 0, layers, &one, 1), BCCSPLAT_ERROR_WRONG_STATE,
                  "layers");
      EXPECT_EQ(bccsplat_writer_set_times(host.writer, 1e30, 1e-30), BCCSPLAT_OK);
      host.refuse_finish("do not rise");
      EXPECT_EQ(bccsplat_writer_set_times(host.writer, 0, 1), BCCSPLAT_OK);
    }
    EXPECT_EQ(bccsplat_writer_finish(host.writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
    return host.bytes;
  };
  EXPECT_EQ(write(true), write(false));
}

int32_t steady(void*, uint64_t count, const double* at, float* values) {
  for (uint64_t i = 0; i < count; ++i)
    values[i] = static_cast<float>(whole_field(at[4 * i], at[4 * i + 1], at[4 * i + 2], at[4 * i + 3]));
  return 0;
}

TEST(RefusedCalls, AFieldIsOneOfItsChannel) {
  const TestDevice device;
  auto o = call_variants().front().options;
  o.dims[3] = 6, o.measure = BCCSPLAT_MEASURE_ALL;
  const auto write = [&](bool meddled) {
    Host host(device, o);
    if (meddled) {
      const std::vector<float> values(size_t{n[0]} * n[1] * n[2]);
      host.expect(bccsplat_writer_add_layer(host.writer, 0, 1, values.data(), values.size()),
                  BCCSPLAT_ERROR_WRONG_STATE, "is next");
      host.expect(bccsplat_writer_add_field(host.writer, 1, steady, nullptr), BCCSPLAT_ERROR_NOT_FOUND,
                  "channel");
    }
    EXPECT_EQ(bccsplat_writer_add_field(host.writer, 0, steady, nullptr), BCCSPLAT_OK)
        << bccsplat_last_error();
    if (meddled)
      host.expect(bccsplat_writer_add_field(host.writer, 0, steady, nullptr), BCCSPLAT_ERROR_WRONG_STATE,
                  "has data already");
    EXPECT_EQ(bccsplat_writer_finish(host.writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
    return host.bytes;
  };
  EXPECT_EQ(write(true), write(false));
}

// Layers cannot be measured, which is found out with the first of them: frames may come instead.
TEST(RefusedCalls, LayersThatCannotBeMeasuredGiveWayToFrames) {
  const TestDevice device;
  auto o = call_variants().front().options;
  o.dims[3] = 4, o.abs_error = 0.5;
  Host host(device, o);
  auto g = sized<bccsplat_layer_geometry>();
  ASSERT_EQ(bccsplat_writer_get_layer_geometry(host.writer, 0, &g), BCCSPLAT_OK);
  const std::vector<float> layer(g.dims[0] * g.dims[1] * g.dims[2], 1);
  host.expect(bccsplat_writer_add_layer(host.writer, 0, 0, layer.data(), layer.size()),
              BCCSPLAT_ERROR_WRONG_STATE, "layers alone");
  for (uint32_t t = 0; t < 4; ++t) {
    const std::vector<float> values = frame_of(t);
    const bccsplat_box box = box_of(values);
    EXPECT_EQ(bccsplat_writer_add_frame(host.writer, 0, t, &box, 1), BCCSPLAT_OK) << bccsplat_last_error();
  }
  EXPECT_EQ(bccsplat_writer_finish(host.writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
}

// A field that gives up ends the writer, as the header says.
TEST(RefusedCalls, WhatFailsInTheWorkEndsTheWriter) {
  const TestDevice device;
  auto o = call_variants().front().options;
  o.dims[3] = 6;
  Host host(device, o);
  const auto give_up = [](void*, uint64_t, const double*, float*) -> int32_t { return 1; };
  EXPECT_EQ(bccsplat_writer_add_field(host.writer, 0, give_up, nullptr), BCCSPLAT_CANCELLED);
  host.expect(bccsplat_writer_add_field(host.writer, 0, steady, nullptr), BCCSPLAT_ERROR_WRONG_STATE,
              "an earlier call failed");
}

} // namespace
} // namespace bccsplat::test
