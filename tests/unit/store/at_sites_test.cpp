// SPDX-License-Identifier: Apache-2.0
// Frames compared with the layers that are stored, where the field goes through them: a reader gets the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "field/sample_grid.h"
#include "slice/time_slice.h"
#include "store/site_planes.h"
#include "tests/unit/store/written_series.h"

namespace bccsplat {
namespace {

using test::Opened;
using test::Series;

constexpr double least = 900, most = 2900;

WriterSettings of_wavelets(const Series& series, double bound) {
  WriterSettings s;
  s.dims = series.dims;
  s.lattice = LatticeKind::cc;
  s.wavelets = true, s.measure = Measure::all;
  ChannelSettings& c = s.channels[0];
  c.value_type = ValueType::u16, c.range = Range{least, most};
  c.wavelet_error = 20, c.abs_error = bound;
  return s;
}

// Noise about a mean that is far from air.
Series rough_series() {
  Series s = test::noise({37, 21, 18, 13}, 4);
  for (float& v : s.values) v = static_cast<float>((least + most) / 2 + v * (most - least) / 3);
  return s;
}

std::vector<float> frame_of(Opened& file, uint32_t t) {
  const auto& n = file.lattice().dims;
  Grid grid;
  grid.dims = {static_cast<int32_t>(n[0]), static_cast<int32_t>(n[1]), static_cast<int32_t>(n[2])};
  std::vector<float> values(size_t{n[0]} * n[1] * n[2]);
  sample_grid(time_slice(*file.coefficients, t, {0, 0}, {}, file.bench.context), grid, values.data(),
              file.bench.context);
  return values;
}

std::vector<float> values_at_sites(const SampleLayer& layer, float base) {
  const Int3& n = layer.dims();
  const size_t plane = size_t(n[0]) * n[1];
  std::vector<float> values(plane * n[2]);
  for (int z = 0; z < n[2]; ++z) read_site_plane(layer, base, z, values.data() + z * plane);
  return values;
}

TEST(AtSites, TheFieldGoesThroughWhatIsStored) {
  const Series series = rough_series();
  std::vector<std::byte> bytes;
  (void)test::write(of_wavelets(series, 0), series, bytes);
  Opened file(std::move(bytes));
  double off = 0;
  for (uint32_t t = 0; t < series.dims[3]; ++t) {
    const auto stored = file.samples.read_layer(0, static_cast<int32_t>(t), {}, file.bench.context);
    const SampleLayer layer(stored);
    const std::vector<float> at_sites = values_at_sites(layer, file.samples.base(0));
    const std::vector<float> field = frame_of(file, t);
    for (size_t i = 0; i < field.size(); ++i) off = std::max(off, std::fabs(double{field[i]} - at_sites[i]));
  }
  const double largest = (most - least) / 2;
  EXPECT_GT(off, 0);
  EXPECT_LT(off, exact_rounding * largest / 2);
}

TEST(AtSites, ABoundHoldsForReadersAndErrorsAreTheirs) {
  const Series series = rough_series();
  std::vector<std::byte> bytes;
  constexpr double bound = 40;
  const WriteReport report = test::write(of_wavelets(series, bound), series, bytes);
  EXPECT_GT(report.corrected, 100u);
  EXPECT_LT(report.corrected, series.values.size() / 10);
  Opened file(std::move(bytes));
  double largest = 0, squares = 0;
  for (uint32_t t = 0; t < series.dims[3]; ++t) {
    const std::vector<float> field = frame_of(file, t);
    for (size_t i = 0; i < field.size(); ++i) {
      const double e = double{field[i]} - series.frame(t)[i];
      largest = std::max(largest, std::fabs(e)), squares += e * e;
    }
  }
  EXPECT_LE(largest, bound);
  for (const MeasuredError& e : file.reader->info().errors) {
    if (e.kind != MeasuredError::corrected) continue;
    EXPECT_NEAR(e.largest, largest, .02);
    const double rms = std::sqrt(squares / static_cast<double>(series.values.size()));
    EXPECT_NEAR(e.rmse, rms, 1e-3 * rms); // files tell few digits
    EXPECT_EQ(e.samples, series.values.size());
    return;
  }
  ADD_FAILURE() << "the file tells no error";
}

// A series of bytes, given as such or as floats.
struct Bytes {
  Series series = test::noise({30, 20, 17, 20}, 9);
  std::vector<uint8_t> values;
  Bytes() : values(series.values.size()) {
    for (size_t i = 0; i < values.size(); ++i)
      series.values[i] = values[i] = static_cast<uint8_t>(128 + 100 * series.values[i]);
  }
  [[nodiscard]] FrameBox box(uint32_t t, SourceType type) const {
    FrameBox box = series.box(t);
    if (type == SourceType::u8) box.data = values.data() + t * series.frame_samples(), box.type = type;
    return box;
  }
};

struct WrittenBytes {
  WriteReport report;
  SampleErrors errors;
  uint64_t peak = 0;
};

WrittenBytes write_bytes(const Bytes& bytes, SourceType type, double bound) {
  WriterSettings settings = of_wavelets(bytes.series, bound);
  ChannelSettings& c = settings.channels[0];
  c.wavelet_error = 3, c.value_type = ValueType::u8, c.source_type = type;
  c.range = {};
  if (type == SourceType::f32) c.range = Range{0, 255};
  test::Bench bench(2);
  std::vector<std::byte> file;
  VolumeWriter writer(settings, create_memory_sink(file), bench.context);
  for (uint32_t t = 0; t < settings.dims[3]; ++t) {
    const FrameBox box = bytes.box(t, type);
    writer.add_frame(0, t, {&box, 1});
  }
  WrittenBytes out;
  out.report = writer.finish();
  out.errors = writer.measured(0, -1).errors, out.peak = bench.memory.peak();
  return out;
}

// Bytes need not be held as frames: they are compared with the layers that were coded.
TEST(AtSites, LayersOfBytesAreTheirSource) {
  const Bytes bytes;
  constexpr double bound = 8.5;
  const WrittenBytes as_bytes = write_bytes(bytes, SourceType::u8, bound),
                     as_floats = write_bytes(bytes, SourceType::f32, bound);
  EXPECT_EQ(as_bytes.report.corrected, as_floats.report.corrected);
  EXPECT_GT(as_bytes.report.corrected, 0u);
  EXPECT_LE(as_bytes.errors.all.largest, bound);
  EXPECT_GT(as_bytes.errors.all.largest, bound - .5);
  EXPECT_GT(as_bytes.errors.bare.largest, bound);
  EXPECT_LT(as_bytes.peak, as_floats.peak - 8 * 4 * bytes.series.frame_samples());
}

// Bytes may be off by all of a bound of whole steps.
TEST(AtSites, ABoundOfWholeStepsIsUsedUp) {
  const Bytes bytes;
  constexpr double bound = 8;
  const WrittenBytes written = write_bytes(bytes, SourceType::u8, bound);
  EXPECT_LE(written.errors.all.largest, bound);
  EXPECT_GT(written.errors.all.largest, bound - .03);
  EXPECT_LT(written.report.corrected, write_bytes(bytes, SourceType::u8, bound - .5).report.corrected);
}

TEST(AtSites, HolesAndAir) {
  const Lattice3 lattice = Lattice4::fit(LatticeKind::cc, {20, 18, 3, 1}, {1, 1, 1, 1}).space;
  BrickLayer layer(lattice, 0);
  auto brick = std::make_shared<Brick>();
  brick->value[brick_rows + 2 * brick_edge + 5] = 4, brick->kept[brick_edge + 2] = 1u << 5;
  brick->hole = std::make_unique<BrickMask>();
  (*brick->hole)[brick_edge + 3] = 1u << 7;
  layer.set(layer.slot(0, 0, 0), brick);
  std::vector<float> plane(20 * 18, -1);
  read_site_plane(SampleLayer(layer), 10, 1, plane.data());
  for (size_t i = 0; i < plane.size(); ++i) {
    if (i == 3 * 20 + 7)
      EXPECT_TRUE(std::isnan(plane[i]));
    else
      EXPECT_EQ(plane[i], i == 2 * 20 + 5 ? 14 : 10) << i;
  }
}

} // namespace
} // namespace bccsplat
