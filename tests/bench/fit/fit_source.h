// SPDX-License-Identifier: Apache-2.0
// Series as a host holds them, and fits of them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "fit/fit.h"
#include "fit/frame/unpack.h"
#include "tests/bench/fit/fit_fields.h"

namespace bccsplat::bench {

// Bytes in which the coefficients of any of them have room.
inline constexpr uint64_t fit_cache = uint64_t{4} << 30;

struct FitSource {
  std::string name;
  std::array<uint32_t, 4> dims{1, 1, 1, 1};
  SourceType type = SourceType::f32;
  std::vector<std::byte> bytes; // packed, x fastest

  [[nodiscard]] size_t frame_samples() const { return size_t{dims[0]} * dims[1] * dims[2]; }
  [[nodiscard]] size_t frame_bytes() const { return frame_samples() * source_bytes(type); }
  [[nodiscard]] FrameBox box(uint32_t frame) const;
  // Frame as floats.
  [[nodiscard]] std::vector<float> frame(uint32_t t) const;
};

// `scale` times the series in another type.
template<class T> FitSource source_of(const FitSeries& s, SourceType type, double scale, std::string name) {
  FitSource r{std::move(name), s.dims, type, std::vector<std::byte>(s.values.size() * sizeof(T))};
  for (size_t i = 0; i < s.values.size(); ++i) {
    const double v = s.values[i] * scale;
    const T value = std::is_integral_v<T> ? static_cast<T>(std::lround(v)) : static_cast<T>(v);
    std::memcpy(r.bytes.data() + i * sizeof(T), &value, sizeof value);
  }
  return r;
}

// A raw file; dims "X,Y,Z,T", type u8, u16 or f32.
[[nodiscard]] FitSource raw_source(const std::string& path, const std::string& dims, const std::string& type);

// The options' dims and quantiser are set from the source. threads 0: all; layers may be null.
[[nodiscard]] FitReport fit_source(const FitSource& source, FitOptions options, int threads,
                                   std::vector<BrickLayer>* layers);

// What comes back at the source samples of three frames in the middle, root mean square and largest error in
// 1/255 of the largest sample: where the source differs from air, where it is air next to something else (one
// of the 80 neighbours in space and time), and elsewhere.
struct RoundTrip {
  FitReport report;
  double psnr = 0,
         psnr_solid = 0; // dB, peak: the largest sample; of all samples, and of those that differ from air
  struct Error {
    double rms = 0, largest = 0;
  };
  Error solid, border, far;
};
[[nodiscard]] RoundTrip round_trip(const FitSource& source, const FitOptions& options,
                                   const std::string& kernel);

} // namespace bccsplat::bench
