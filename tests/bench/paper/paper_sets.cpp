// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "base/error.h"
#include "tests/bench/paper/paper.h"

#ifdef BCCSPLAT_BENCH_READERS
#include "readers/error.h"
#include "readers/open_series.h"
#endif

namespace bccsplat::bench {

std::span<const PaperSet> paper_sets() {
  static constexpr PaperSet sets[] = {
      {"neghip", "neghip_64x64x64_u8.raw", "64,64,64", "", false},
      {"fuel", "fuel_64x64x64_u8.vti", "", "", false},
      {"tooth", "tooth_103x94x161_u8.nrrd", "", "", false},
      {"engine", "engine_256x256x128_u8.raw.gz", "256,256,128", "", false},
      {"bonsai", "bonsai_256x256x256_u8_zlib.vti", "", "", false},
      {"pcasl", "pcasl_52x68x20x10_f32.nii.gz", "", "", true},
      {"forecast", "ncep_forecast_36x33x10x7_f32.nc", "", "T", true},
      {"viscous-fingers", "viscous_fingers_run01_64x64x64x99_u16.nrrd", "", "", true}};
  return sets;
}

std::span<const PaperSet> real_series() {
  static constexpr PaperSet sets[] = {{"fingers", "viscous_fingers_run01_64x64x64x99_u16.nrrd", "", "", true},
                                      {"heart", "cardiac_cine_256x256x19x20_i16.nii.gz", "", "", true},
                                      {"hurricane", "isabel_windspeed_125x125x25x12_u16.nrrd", "", "", true},
                                      {"pcasl", "pcasl_52x68x20x10_f32.nii.gz", "", "", true},
                                      {"forecast", "ncep_forecast_36x33x10x7_f32.nc", "", "T", true}};
  return sets;
}

#ifdef BCCSPLAT_BENCH_READERS

std::optional<FitSource> load_paper_set(const PaperSet& set, const std::string& folder) {
  const std::filesystem::path path = std::filesystem::path(folder) / set.file;
  if (!std::filesystem::exists(path)) return std::nullopt;
  bcc4::ReaderOptions options;
  options.inputs = {path.string()};
  if (*set.channel) options.channels = {set.channel};
  if (*set.dims) {
    std::array<uint64_t, 4> dims{0, 0, 0, 1};
    if (std::sscanf(set.dims, "%lu,%lu,%lu", &dims[0], &dims[1], &dims[2]) != 3)
      fail(Code::internal, set.name, ": dims ", set.dims);
    options.dims = dims;
    options.dtype = bcc4::Type::u8;
  }
  try {
    const auto reader = bcc4::open_series(options);
    const bcc4::SeriesDescription& d = reader->description();
    const bcc4::Type precision = d.channels[0].precision;
    const bool wide = bcc4::type_size(precision) == 2 && !bcc4::is_float(precision),
               bytes = precision == bcc4::Type::u8;
    FitSeries s;
    for (size_t a = 0; a < 4; ++a) s.dims[a] = static_cast<uint32_t>(d.dims[a]);
    std::vector<double> plane(d.dims[0] * d.dims[1]);
    for (uint64_t t = 0; t < d.dims[3]; ++t) {
      const bcc4::Frame frame = reader->read(t, 0);
      for (uint64_t z = 0; z < d.dims[2]; ++z) {
        bcc4::gather_plane(frame, d.dims, z, d.channels[0].air, plane.data());
        for (const double v : plane) s.values.push_back(std::isfinite(v) ? static_cast<float>(v) : 0);
      }
    }
    if (bytes) return source_of<uint8_t>(s, SourceType::u8, 1, set.name);
    if (precision == bcc4::Type::i16) return source_of<int16_t>(s, SourceType::i16, 1, set.name);
    return wide ? source_of<uint16_t>(s, SourceType::u16, 1, set.name)
                : source_of<float>(s, SourceType::f32, 1, set.name);
  } catch (const bcc4::Error& e) {
    fail(Code::io_error, path.string(), ": ", e.what());
  }
}

#else

std::optional<FitSource> load_paper_set(const PaperSet&, const std::string&) { return std::nullopt; }

#endif

} // namespace bccsplat::bench
