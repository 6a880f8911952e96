// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/fit/zfp_size.h"

#include <algorithm>
#include <cmath>
#include <vector>

#ifdef BCCSPLAT_BENCH_ZFP
#include <zfp.h>
#endif

namespace bccsplat::bench {

#ifdef BCCSPLAT_BENCH_ZFP

namespace {

struct SizeOfAccuracy {
  double bytes = 0, psnr = 0;
};

SizeOfAccuracy code(const std::vector<float>& values, const std::array<uint32_t, 4>& n, double tolerance,
                    double peak) {
  std::vector<float> copy = values;
  zfp_field* const field = zfp_field_4d(copy.data(), zfp_type_float, n[0], n[1], n[2], n[3]);
  zfp_stream* const zfp = zfp_stream_open(nullptr);
  zfp_stream_set_accuracy(zfp, tolerance);
  std::vector<unsigned char> buffer(zfp_stream_maximum_size(zfp, field));
  bitstream* const bits = stream_open(buffer.data(), buffer.size());
  zfp_stream_set_bit_stream(zfp, bits);
  zfp_stream_rewind(zfp);
  const auto bytes = static_cast<double>(zfp_compress(zfp, field));
  zfp_stream_rewind(zfp);
  std::fill(copy.begin(), copy.end(), 0.0f);
  (void)zfp_decompress(zfp, field);
  zfp_field_free(field);
  zfp_stream_close(zfp);
  stream_close(bits);
  double squares = 0;
  for (size_t i = 0; i < values.size(); ++i) squares += std::pow(static_cast<double>(copy[i]) - values[i], 2);
  return {bytes, 20 * std::log10(peak / std::sqrt(squares / static_cast<double>(values.size())))};
}

} // namespace

std::optional<double> zfp_bytes(const FitSource& source, double psnr) {
  std::vector<float> values;
  for (uint32_t t = 0; t < source.dims[3]; ++t) {
    const std::vector<float> frame = source.frame(t);
    values.insert(values.end(), frame.begin(), frame.end());
  }
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double peak = *high - *low;
  // Accuracies are powers of two.
  SizeOfAccuracy coarse;
  for (double tolerance = std::exp2(std::ceil(std::log2(peak))); tolerance > peak * 1e-9; tolerance /= 2) {
    const SizeOfAccuracy fine = code(values, source.dims, tolerance, peak);
    if (fine.psnr < psnr) {
      coarse = fine;
      continue;
    }
    if (coarse.bytes == 0 || fine.psnr == coarse.psnr) return fine.bytes;
    return coarse.bytes + (fine.bytes - coarse.bytes) * (psnr - coarse.psnr) / (fine.psnr - coarse.psnr);
  }
  return std::nullopt;
}

#else

std::optional<double> zfp_bytes(const FitSource&, double) { return std::nullopt; }

#endif

} // namespace bccsplat::bench
