// SPDX-License-Identifier: Apache-2.0
// Reads raw series, takes sources through the fit, and compares the field with three frames of the source,
// apart for samples of an object, around it and far from it.
#include "tests/bench/fit/fit_source.h"

#include <algorithm>
#include <string_view>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"
#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "kernel/kernel.h"
#include "points/sample_source.h"

namespace bccsplat::bench {

FrameBox FitSource::box(uint32_t frame) const {
  FrameBox b;
  b.type = type;
  b.dims = {dims[0], dims[1], dims[2]};
  b.data = bytes.data() + frame * frame_bytes();
  return b;
}

std::vector<float> FitSource::frame(uint32_t t) const {
  std::vector<float> values(frame_samples());
  unpack_row(type, static_cast<const std::byte*>(box(t).data), source_bytes(type), values.size(), 0,
             values.data());
  return values;
}

FitSource raw_source(const std::string& path, const std::string& dims, const std::string& type) {
  FitSource s;
  s.name = path.substr(path.rfind('/') + 1);
  s.type = type == "u8"    ? SourceType::u8
           : type == "u16" ? SourceType::u16
           : type == "f32" ? SourceType::f32
                           : SourceType::unknown;
  if (s.type == SourceType::unknown)
    fail(Code::invalid_argument, "--dtype is u8, u16 or f32, not '", type, "'");
  std::string_view rest = dims;
  for (size_t a = 0; a < 4; ++a) {
    const size_t comma = a < 3 ? rest.find(',') : rest.size();
    const auto n = comma == rest.npos ? std::nullopt : parse_number<uint32_t>(rest.substr(0, comma));
    if (!n || *n == 0) fail(Code::invalid_argument, "--dims is X,Y,Z,T, not '", dims, "'");
    s.dims[a] = *n;
    rest = a < 3 ? rest.substr(comma + 1) : rest;
  }
  const auto file = open_file_source(path);
  s.bytes.resize(s.frame_bytes() * s.dims[3]);
  if (file->size() != s.bytes.size())
    fail(Code::invalid_argument, path, " has ", file->size(), " bytes, not ", s.bytes.size());
  file->read_at(0, s.bytes);
  return s;
}

FitReport fit_source(const FitSource& source, FitOptions options, int threads,
                     std::vector<BrickLayer>* layers) {
  Tasks tasks(threads);
  MemoryBudget memory;
  Progress progress;
  options.dims = source.dims;
  options.channels[0].quantiser = quantiser_of_source(source.type, 0);
  Fit fit(options,
          [&](int32_t, int, std::span<const BrickLayer> given) {
            if (layers) layers->insert(layers->end(), given.begin(), given.end());
          },
          {tasks, memory, progress});
  for (uint32_t t = 0; t < source.dims[3]; ++t) {
    const FrameBox box = source.box(t);
    fit.add_frame(0, {&box, 1});
  }
  return fit.finish();
}

namespace {

// 1 where a sample differs from air, grown by one sample along an axis.
void grow(std::vector<uint8_t>& mask, size_t length, size_t stride) {
  const std::vector<uint8_t> from = mask;
  for (size_t i = 0; i < mask.size(); ++i) {
    const size_t p = i / stride % length;
    if (p > 0) mask[i] = mask[i] | from[i - stride];
    if (p + 1 < length) mask[i] = mask[i] | from[i + stride];
  }
}

} // namespace

RoundTrip round_trip(const FitSource& source, const FitOptions& options, const std::string& kernel) {
  RoundTrip result;
  std::vector<BrickLayer> layers;
  result.report = fit_source(source, options, 0, &layers);
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  const Context context{tasks, memory, progress};
  const MemorySamples samples(result.report.lattice, {0.0f}, {layers});
  const Coefficients coefficients(samples, 0, make_kernel(kernel), 0, 1ull << 31);
  const double peak = result.report.channels[0].source_range.high;

  struct Sum {
    double square = 0, largest = 0;
    uint64_t count = 0;
    [[nodiscard]] RoundTrip::Error error(double unit) const {
      return {count ? std::sqrt(square / static_cast<double>(count)) / unit : 0, largest / unit};
    }
  };
  std::array<Sum, 3> sums; // solid, border, far
  const uint32_t nx = source.dims[0], ny = source.dims[1], nz = source.dims[2], middle = source.dims[3] / 2;
  for (uint32_t t = middle > 0 ? middle - 1 : 0; t <= std::min(middle + 1, source.dims[3] - 1); ++t) {
    const std::vector<float> truth = source.frame(t);
    std::vector<uint8_t> near(truth.size(), 0);
    for (uint32_t u = t > 0 ? t - 1 : 0; u <= std::min(t + 1, source.dims[3] - 1); ++u) {
      const std::vector<float> frame = source.frame(u);
      for (size_t i = 0; i < frame.size(); ++i) near[i] = near[i] | (frame[i] != 0);
    }
    grow(near, nx, 1);
    grow(near, ny, nx);
    grow(near, nz, size_t{nx} * ny);
    std::vector<Vec4> points;
    for (uint32_t z = 0; z < nz; ++z)
      for (uint32_t y = 0; y < ny; ++y)
        for (uint32_t x = 0; x < nx; ++x) points.push_back({double(x), double(y), double(z), double(t)});
    std::vector<float> values(points.size());
    (void)evaluate4(coefficients, points, values, {}, context);
    for (size_t i = 0; i < values.size(); ++i) {
      const double e = std::fabs(static_cast<double>(values[i]) - truth[i]);
      Sum& sum = sums[truth[i] != 0 ? 0 : near[i] ? 1 : 2];
      sum.square += e * e;
      sum.largest = std::max(sum.largest, e);
      ++sum.count;
    }
  }
  double square = 0;
  uint64_t count = 0;
  for (const Sum& sum : sums) {
    square += sum.square;
    count += sum.count;
  }
  result.psnr = 20 * std::log10(peak / std::sqrt(square / static_cast<double>(count)));
  result.psnr_solid = 20 * std::log10(peak / std::sqrt(sums[0].square / static_cast<double>(sums[0].count)));
  result.solid = sums[0].error(peak / 255);
  result.border = sums[1].error(peak / 255);
  result.far = sums[2].error(peak / 255);
  return result;
}

} // namespace bccsplat::bench
