// SPDX-License-Identifier: Apache-2.0
// Frames read at the source's samples: what slices have there, whole and in boxes, whatever the file holds;
// and no more is read than the box where the file has these samples themselves.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

using Box = std::array<std::array<uint64_t, 3>, 2>; // begin, end

std::vector<float> read(const OpenVolume& volume, uint64_t frame, const Box& box) {
  std::vector<float> values(1);
  for (size_t a = 0; a < 3; ++a) values.resize(values.size() * (box[1][a] - box[0][a]));
  EXPECT_EQ(bccsplat_volume_read_frame(volume.volume, 0, frame, box[0].data(), box[1].data(), values.data()),
            BCCSPLAT_OK)
      << bccsplat_last_error();
  return values;
}

// The largest difference of a box of a frame from the samples of a slice; no value stands for no value alone.
double off_by(const std::vector<float>& slice, const std::array<uint64_t, 3>& dims,
              const std::vector<float>& got, const Box& box) {
  double largest = 0;
  size_t n = 0;
  for (uint64_t z = box[0][2]; z < box[1][2]; ++z)
    for (uint64_t y = box[0][1]; y < box[1][1]; ++y)
      for (uint64_t x = box[0][0]; x < box[1][0]; ++x, ++n) {
        const float expected = slice[(z * dims[1] + y) * dims[0] + x];
        if (std::isnan(expected) != std::isnan(got[n])) return HUGE_VAL;
        if (!std::isnan(expected)) largest = larger(largest, std::fabs(expected - got[n]));
      }
  return largest;
}

void expect_frames_of_slices(const OpenVolume& volume, double at_most, size_t missing = 0) {
  auto info = sized<bccsplat_volume_info>();
  ASSERT_EQ(bccsplat_volume_get_info(volume.volume, &info), BCCSPLAT_OK);
  const std::array<uint64_t, 3> n{info.dims[0], info.dims[1], info.dims[2]};
  size_t holes = 0;
  for (uint64_t t = 0; t < info.dims[3]; t += 3) {
    const Cut cut(volume, {0, 0, 0, 1, -static_cast<double>(t)});
    const std::vector<float> slice = cut.samples();
    const std::array<uint64_t, 3> dims{cut.info.dims[0], cut.info.dims[1], cut.info.dims[2]};
    const Box all{{{0, 0, 0}, n}}, part{{{3, 0, n[2] / 2}, {n[0] - 2, 7, n[2] / 2 + 1}}};
    for (const Box& box : {all, part}) {
      const std::vector<float> got = read(volume, t, box);
      EXPECT_LE(off_by(slice, dims, got, box), at_most) << "frame " << t;
      holes += std::count_if(got.begin(), got.end(), [](float v) { return std::isnan(v); });
    }
    std::vector<float> whole(n[0] * n[1] * n[2]);
    ASSERT_EQ(bccsplat_volume_read_frame(volume.volume, 0, t, nullptr, nullptr, whole.data()), BCCSPLAT_OK);
    EXPECT_LE(off_by(slice, dims, whole, all), at_most);
  }
  EXPECT_EQ(holes > 0, missing > 0);
}

double waves(double x, double y, double z, double t) {
  return 100 + 90 * std::sin(.31 * x + .23 * y - .3 * t) * std::cos(.17 * z + .1 * t) + 5 * std::sin(2.1 * x);
}
double with_holes(double x, double y, double z, double t) {
  return x < 9 + 3 * std::sin(y / 3) && z < 11 + t / 2 ? NAN : waves(x, y, z, t);
}

const std::array<uint32_t, 4> dims{41, 30, 37, 13};

// bound: of the error at samples; 0: none.
bccsplat_writer_options on_own_grid(bccsplat_store store, double bound = 0) {
  static const double error = 1;
  auto options = sized<bccsplat_writer_options>();
  options.lattice = BCCSPLAT_LATTICE_CC, options.recommended_kernel = "exact", options.store = store;
  options.nonfinite = BCCSPLAT_NONFINITE_HOLE, options.abs_error = bound;
  if (store == BCCSPLAT_STORE_WAVELETS && bound == 0) options.wavelet_errors = &error;
  return options;
}
bccsplat_channel_options in_codes() {
  auto channel = sized<bccsplat_channel_options>();
  channel.value_type = BCCSPLAT_TYPE_U8, channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE;
  channel.range[0] = 0, channel.range[1] = 200;
  return channel;
}

TEST(ReadFrame, IsWhatSlicesHave) {
  const TestDevice device;
  for (const bool holes : {false, true})
    for (const bccsplat_store store : {BCCSPLAT_STORE_WAVELETS, BCCSPLAT_STORE_SAMPLES})
      for (const double bound : {0.0, 2.0}) {
        SCOPED_TRACE(testing::Message() << "store " << store << ", bound " << bound << ", holes " << holes);
        const Source s = source_of(dims, BCCSPLAT_TYPE_F32, holes ? with_holes : waves);
        const Written w = write_frames(device, s, on_own_grid(store, bound), in_codes());
        ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
        expect_frames_of_slices(OpenVolume(device, w.bytes), .02, holes);
      }
}

// Where the field does not go through stored samples, a frame is the slice, to the bit.
TEST(ReadFrame, OfOtherFilesIsTheSlice) {
  const TestDevice device;
  const Source s = source_of(dims, BCCSPLAT_TYPE_F32, waves);
  auto finer = sized<bccsplat_writer_options>();
  finer.lattice = BCCSPLAT_LATTICE_CC, finer.scale = .8;
  for (const bccsplat_writer_options& options : {sized<bccsplat_writer_options>(), finer}) {
    const Written w = write_frames(device, s, options);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    expect_frames_of_slices(OpenVolume(device, w.bytes), 0);
  }
  const Written own = write_frames(device, s, on_own_grid(BCCSPLAT_STORE_SAMPLES), in_codes());
  ASSERT_EQ(own.status, BCCSPLAT_OK) << own.text;
  expect_frames_of_slices(OpenVolume(device, own.bytes, "default"), 0); // looked at under another kernel
}

// Corrections are those of the file's own kernel: under another that goes through the samples there are none.
TEST(ReadFrame, HasNoCorrectionsOfAnotherKernel) {
  const TestDevice device;
  bccsplat_writer_options options = on_own_grid(BCCSPLAT_STORE_SAMPLES, 1);
  options.recommended_kernel = "default";
  auto coarse = in_codes();
  coarse.range[1] = 900;
  const Written w = write_frames(device, source_of(dims, BCCSPLAT_TYPE_F32, waves), options, coarse);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  EXPECT_GT(w.report.corrected, 0u);
  expect_frames_of_slices(OpenVolume(device, w.bytes, "exact"), .02);
  expect_frames_of_slices(OpenVolume(device, w.bytes), 0);
}

// Also along axes that have no ends, of which a slice has the first sample once more.
TEST(ReadFrame, HasThePlacesOfPeriodicAxes) {
  const TestDevice device;
  bccsplat_writer_options options = on_own_grid(BCCSPLAT_STORE_WAVELETS);
  options.periodic_axes = BCCSPLAT_PERIODIC_X, options.ends = BCCSPLAT_ENDS_PERIODIC;
  const double turn = 2 * M_PI;
  const Source s =
      source_of({40, 17, 18, 12}, BCCSPLAT_TYPE_F32, [&](double x, double y, double z, double t) {
        return 100 + 80 * std::sin(turn * x / 40 + y / 5) * std::cos(z / 6 + turn * t / 12);
      });
  const Written w = write_frames(device, s, options, in_codes());
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  expect_frames_of_slices(OpenVolume(device, w.bytes), .02);
}

// Noise that nothing predicts, and numbers of things: what is stored without loss comes back as it was.
TEST(ReadFrame, GivesLosslessNumbersAsTheyWere) {
  const TestDevice device;
  std::mt19937 random(3);
  for (const uint32_t most : {255u, 5u}) {
    const Source s = source_of({33, 18, 20, 5}, BCCSPLAT_TYPE_U8,
                               [&](double, double, double, double) { return random() % (most + 1); });
    auto channel = in_codes();
    channel.range[1] = 255;
    const Written w = write_frames(device, s, on_own_grid(BCCSPLAT_STORE_SAMPLES), channel);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const OpenVolume volume(device, w.bytes);
    const Box box{{{2, 1, 3}, {31, 18, 20}}};
    for (uint32_t t = 0; t < 5; ++t) {
      const std::vector<float> got = read(volume, t, box);
      size_t n = 0, wrong = 0;
      for (size_t z = 3; z < 20; ++z)
        for (size_t y = 1; y < 18; ++y)
          for (size_t x = 2; x < 31; ++x) wrong += got[n++] != s.values[((t * 20 + z) * 18 + y) * 33 + x];
      EXPECT_EQ(wrong, 0u) << "frame " << t;
    }
  }
}

// Bytes that are read of a file in memory.
struct CountedFile {
  const Bytes& bytes;
  uint64_t read = 0;
  [[nodiscard]] bccsplat_read_stream stream() {
    auto stream = sized<bccsplat_read_stream>();
    stream.user = this, stream.size = bytes.size();
    stream.read_at = [](void* user, uint64_t offset, void* buffer, uint64_t size) {
      auto& file = *static_cast<CountedFile*>(user);
      std::copy_n(file.bytes.data() + offset, size, static_cast<unsigned char*>(buffer));
      file.read += size;
      return static_cast<int64_t>(size);
    };
    return stream;
  }
};

// What is read of a file after it was opened.
template<class Look> uint64_t bytes_read(const TestDevice& device, const Bytes& bytes, const Look& look) {
  CountedFile file{bytes};
  const bccsplat_read_stream stream = file.stream();
  bccsplat_volume* volume = nullptr;
  EXPECT_EQ(bccsplat_volume_open_stream(device.device, &stream, nullptr, &volume), BCCSPLAT_OK);
  file.read = 0;
  look(volume);
  bccsplat_volume_release(volume);
  return file.read;
}

TEST(ReadFrame, ReadsTheBoxAndTheFrameAlone) {
  const TestDevice device;
  std::mt19937 random(7);
  const Source s =
      source_of({130, 70, 40, 36}, BCCSPLAT_TYPE_F32, [&](double x, double y, double z, double t) {
        return waves(x, y, z, t) + static_cast<double>(random() % 64) / 8;
      });
  const Written w = write_frames(device, s, on_own_grid(BCCSPLAT_STORE_WAVELETS), in_codes());
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  const auto bytes_of = [&](const auto& look) { return bytes_read(device, w.bytes, look); };
  const std::array<double, 6> place{66, 4, 4, 97, 35, 35};
  const uint64_t sliced = bytes_of([&](bccsplat_volume* volume) {
    auto options = sized<bccsplat_slice_options>();
    options.box = place.data();
    auto plane = sized<bccsplat_hyperplane>();
    plane.d = 1, plane.e = -17.5; // a moment
    bccsplat_slice* slice = nullptr;
    EXPECT_EQ(bccsplat_slice_create(volume, &plane, &options, &slice), BCCSPLAT_OK) << bccsplat_last_error();
    bccsplat_slice_release(slice);
  });
  const uint64_t read = bytes_of([&](bccsplat_volume* volume) {
    const Box box{{{66, 4, 4}, {98, 36, 36}}};
    std::vector<float> values(size_t{32} * 32 * 32);
    EXPECT_EQ(bccsplat_volume_read_frame(volume, 0, 17, box[0].data(), box[1].data(), values.data()),
              BCCSPLAT_OK);
  });
  EXPECT_GT(read, 0u);
  EXPECT_LT(read, sliced / 3);
}

// Nearly every sample has a correction: those of all bricks would be a quarter of what a frame reads.
TEST(ReadFrame, ReadsTheCorrectionsOfTheBoxAlone) {
  const TestDevice device;
  std::mt19937 random(5);
  const Source s = source_of({320, 12, 12, 2}, BCCSPLAT_TYPE_F32, [&](double, double, double, double) {
    return static_cast<double>(random() % 20000) / 100;
  });
  const Written w = write_frames(device, s, on_own_grid(BCCSPLAT_STORE_SAMPLES, .05), in_codes());
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  std::vector<float> values(s.frame_samples());
  const auto read = [&](const Box& box) {
    return bytes_read(device, w.bytes, [&](bccsplat_volume* volume) {
      EXPECT_EQ(bccsplat_volume_read_frame(volume, 0, 1, box[0].data(), box[1].data(), values.data()),
                BCCSPLAT_OK);
    });
  };
  const uint64_t all = read({{{0, 0, 0}, {320, 12, 12}}}), some = read({{{130, 2, 3}, {140, 9, 11}}});
  EXPECT_LT(some, all / 6);
  for (size_t n = 0, z = 3; z < 11; ++z)
    for (size_t y = 2; y < 9; ++y)
      for (size_t x = 130; x < 140; ++x)
        ASSERT_NEAR(values[n++], s.values[((12 + z) * 12 + y) * 320 + x], .05 + 1e-5);
}

TEST(ReadFrame, RefusesWhatIsNotThere) {
  const TestDevice device;
  const Source s = source_of(dims, BCCSPLAT_TYPE_F32, waves);
  const Written w = write_frames(device, s, on_own_grid(BCCSPLAT_STORE_SAMPLES));
  const OpenVolume volume(device, w.bytes);
  std::vector<float> values(s.frame_samples());
  const auto status = [&](uint32_t channel, uint64_t frame, std::array<uint64_t, 3> begin,
                          std::array<uint64_t, 3> end) {
    return bccsplat_volume_read_frame(volume.volume, channel, frame, begin.data(), end.data(), values.data());
  };
  EXPECT_EQ(status(0, 12, {0, 0, 0}, {41, 30, 37}), BCCSPLAT_OK);
  EXPECT_EQ(status(1, 0, {0, 0, 0}, {1, 1, 1}), BCCSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(status(0, 13, {0, 0, 0}, {1, 1, 1}), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_EQ(status(0, UINT64_MAX, {0, 0, 0}, {1, 1, 1}), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_EQ(status(0, 0, {0, 0, 0}, {42, 1, 1}), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_EQ(status(0, 0, {0, 0, 0}, {1, 1, UINT64_MAX}), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_EQ(status(0, 0, {2, 0, 0}, {2, 1, 1}), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(status(0, 0, {3, 0, 0}, {2, 1, 1}), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  const std::array<uint64_t, 3> one{1, 1, 1};
  EXPECT_EQ(bccsplat_volume_read_frame(volume.volume, 0, 0, nullptr, one.data(), values.data()),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_volume_read_frame(nullptr, 0, 0, nullptr, nullptr, values.data()),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_volume_read_frame(volume.volume, 0, 0, nullptr, nullptr, nullptr),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

} // namespace
} // namespace bccsplat::test
