// SPDX-License-Identifier: Apache-2.0
// A large constant with a small signal through whole files whose air is 0, as a host with cleared options
// writes them, where a few samples are air or missing and where a bound is kept.
#include <cmath>
#include <limits>
#include <random>

#include "field/coefficients/coefficients.h"
#include "field/corrections.h"
#include "field/evaluate.h"
#include "formats/bcc4/read/frame_sources.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "store/volume_writer.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/support/fields.h"
#include "tests/support/plane_waves.h"

namespace bccsplat::bench {
namespace {

constexpr double pressure = 101325, signal = 50;
constexpr std::array<uint32_t, 4> dims{28, 28, 28, 64};

enum class Gap { none, one_zero, one_missing, one_plane, one_frame };
struct Case {
  const char* what;
  Gap gap = Gap::none;
  double bound = 0, amplitude = signal;
};

// Frames one after the other, x fastest.
std::vector<float> sampled_waves(const test::PlaneWaves& waves) {
  std::vector<float> values;
  for (uint32_t t = 0; t < dims[3]; ++t)
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x)
          values.push_back(static_cast<float>(waves({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t})));
  return values;
}

std::vector<std::byte> stored(const Case& made, const std::vector<float>& waves) {
  test::TestContext context;
  WriterSettings settings;
  settings.dims = dims, settings.nonfinite = NonFinite::hole, settings.channels[0].abs_error = made.bound;
  std::vector<std::byte> file;
  VolumeWriter writer(settings, create_memory_sink(file), context.get());
  const size_t n = size_t{dims[0]} * dims[1] * dims[2];
  for (uint32_t t = 0; t < dims[3]; ++t) {
    std::vector<float> values(waves.begin() + (t * n), waves.begin() + ((t + 1) * n));
    for (float& v : values) v = static_cast<float>(pressure + made.amplitude * v);
    if (t == 0 && made.gap == Gap::one_zero) values[0] = 0;
    if (t == 0 && made.gap == Gap::one_missing) values[0] = std::numeric_limits<float>::quiet_NaN();
    FrameBox box;
    box.type = SourceType::f32, box.data = values.data();
    box.dims = {dims[0], dims[1], dims[2]};
    if (t == 0 && made.gap == Gap::one_plane) --box.dims[2];
    writer.add_frame(0, t, {&box, t == 0 && made.gap == Gap::one_frame ? 0u : 1u});
  }
  (void)writer.finish();
  return file;
}

Row row_of(const Case& made, const test::PlaneWaves& waves, const std::vector<float>& at_samples,
           size_t count) {
  const std::vector<std::byte> file = stored(made, at_samples);
  test::TestContext context;
  const std::shared_ptr<Bcc4Reader> reader = Bcc4Reader::open(open_memory_source(file));
  const Bcc4Samples samples(reader, context.memory, 256 << 20, RelativeTo::base);
  Coefficients field(samples, 0, make_kernel("default"), 0, 4ull << 30);
  const Corrections corrections(std::make_unique<Bcc4Corrections>(reader, 0), context.memory, 64 << 20);
  if (made.bound > 0) field.set_corrections(&corrections);
  const std::vector<Vec4> points = test::random_points(reader->info().lattice, count, 5, 10);
  std::vector<float> values(count);
  std::vector<std::array<float, 4>> gradients(count);
  (void)evaluate4(field, points, values, gradients, context.get());
  double error = 0, steep_error = 0;
  for (size_t i = 0; i < count; ++i) {
    const Vec4 g = waves.gradient(points[i]);
    error += std::pow(values[i] - pressure - made.amplitude * waves(points[i]), 2);
    for (size_t a = 0; a < 4; ++a) steep_error += std::pow(gradients[i][a] - made.amplitude * g[a], 2);
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / static_cast<double>(count)); };
  return {word("written with air 0", made.what),
          figure("base", samples.base(0), 1),
          figure("RMS error of values", rms(error), 4),
          figure("of gradients", rms(steep_error), 4),
          figure("corrections", static_cast<double>(made.bound > 0 ? corrections.count() : 0), 0),
          figure("KiB", static_cast<double>(file.size()) / 1024, 0)};
}

} // namespace

void report_constant_files(const Report& report) {
  constexpr Case cases[] = {{"a constant", Gap::none, 0, 0},
                            {"a constant to 2 Pa", Gap::none, 2, 0},
                            {"a constant, one sample 0", Gap::one_zero, 0, 0},
                            {"waves"},
                            {"one sample missing", Gap::one_missing},
                            {"one sample 0", Gap::one_zero},
                            {"a plane of a frame not given", Gap::one_plane},
                            {"a frame not given", Gap::one_frame},
                            {"to 2 Pa", Gap::none, 2},
                            {"to 2 Pa, one sample missing", Gap::one_missing, 2},
                            {"to 2 Pa, one sample 0", Gap::one_zero, 2}};
  const test::PlaneWaves waves(60, 0.3, 5);
  const std::vector<float> at_samples = sampled_waves(waves);
  std::vector<Row> rows;
  for (const Case& c : cases) rows.push_back(row_of(c, waves, at_samples, report.quick ? 300 : 4000));
  report.table("101325 Pa and waves of 50 Pa through whole files", rows);
}

} // namespace bccsplat::bench
