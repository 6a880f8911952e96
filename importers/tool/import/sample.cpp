#include "tool/import/sample.h"

#include <algorithm>
#include <cmath>

#include "tool/interrupt.h"

namespace bcc4 {
namespace {

// Where a box of `edge` samples starts so that its centre is as near to the mean position of what is not air
// as the frame allows.
std::array<uint64_t, 3> busy_corner(const Frame& frame, const std::array<uint64_t, 4>& dims, double air,
                                    const std::array<uint64_t, 3>& edge) {
  std::array<double, 3> sum{};
  double count = 0;
  std::vector<double> plane(dims[0] * dims[1]);
  for (uint64_t z = 0; z < dims[2]; ++z) {
    gather_plane(frame, dims, z, air, plane.data());
    for (uint64_t i = 0; i < plane.size(); ++i) {
      if (!std::isfinite(plane[i]) || plane[i] == air) continue;
      sum[0] += static_cast<double>(i % dims[0]);
      const uint64_t row = i / dims[0];
      sum[1] += static_cast<double>(row);
      sum[2] += static_cast<double>(z);
      ++count;
    }
  }
  std::array<uint64_t, 3> begin{};
  for (size_t a = 0; a < 3; ++a) {
    const double centre = count > 0 ? sum[a] / count : static_cast<double>(dims[a]) / 2;
    const double first = std::floor(centre - static_cast<double>(edge[a]) / 2 + 0.5);
    begin[a] = static_cast<uint64_t>(std::clamp(first, 0.0, static_cast<double>(dims[a] - edge[a])));
  }
  return begin;
}

} // namespace

std::vector<SampleStretch> sample_series(FrameReader& reader, const std::vector<double>& air,
                                         const SampleSize& size) {
  const SeriesDescription& s = reader.description();
  const bool whole = s.dims[3] <= size.frames * size.stretches;
  const uint64_t count = whole ? 1 : size.stretches, frames = whole ? s.dims[3] : size.frames;
  std::vector<SampleStretch> stretches(count);
  for (uint64_t i = 0; i < count; ++i) {
    SampleStretch& out = stretches[i];
    out.first = (s.dims[3] - frames) * (2 * i + 1) / (2 * count);
    out.frames = frames;
    for (size_t a = 0; a < 3; ++a) out.box.dims[a] = std::min(s.dims[a], size.edge);
    out.values.resize(s.channels.size());
    std::vector<double> plane(s.dims[0] * s.dims[1]);
    for (uint64_t f = 0; f < frames; ++f)
      for (size_t c = 0; c < s.channels.size(); ++c) {
        stop_if_interrupted();
        const Frame frame = reader.read(out.first + f, c);
        if (f == 0 && c == 0) out.box.begin = busy_corner(frame, s.dims, air[0], out.box.dims);
        for (uint64_t z = 0; z < out.box.dims[2]; ++z) {
          gather_plane(frame, s.dims, out.box.begin[2] + z, air[c], plane.data());
          for (uint64_t y = 0; y < out.box.dims[1]; ++y) {
            const double* row = plane.data() + (out.box.begin[1] + y) * s.dims[0] + out.box.begin[0];
            for (uint64_t x = 0; x < out.box.dims[0]; ++x)
              out.values[c].push_back(static_cast<float>(row[x]));
          }
        }
      }
  }
  return stretches;
}

SeriesDescription describe_stretch(const SeriesDescription& series, const SampleStretch& stretch) {
  SeriesDescription s = series;
  std::copy(stretch.box.dims.begin(), stretch.box.dims.end(), s.dims.begin());
  s.dims[3] = stretch.frames;
  const auto first = series.times.values.begin() + static_cast<std::ptrdiff_t>(stretch.first);
  s.times.values.assign(first, first + static_cast<std::ptrdiff_t>(stretch.frames));
  for (Channel& c : s.channels) c.type = Type::f32;
  s.sparse = false;
  return s;
}

} // namespace bcc4
