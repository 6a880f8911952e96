// SPDX-License-Identifier: Apache-2.0
// Parts of the suite `slice`.
#pragma once

#include <string>
#include <vector>

#include "points/sample_source.h"
#include "slice/hyperslice.h"
#include "tests/bench/report.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {

// Bytes in which the coefficients of any volume here have room.
inline constexpr uint64_t large_cache = uint64_t{8} << 30;

// Hyperplanes through the centre of a volume.
struct NamedPlane {
  std::string name;
  Hyperplane h;
};
[[nodiscard]] std::vector<NamedPlane> planes_through_centre(const std::array<uint32_t, 4>& dims);

// Soft balls that drift and swell, in air 0; radius: of the widest, in samples.
struct Balls {
  std::array<uint32_t, 4> dims;
  double radius;
  [[nodiscard]] double operator()(const Vec4& p) const;
};

// SNR in dB of a slice against f, at random points `margin` inside the domain.
[[nodiscard]] double slice_snr(const Slice& slice, const std::array<uint32_t, 4>& dims, const test::Field4& f,
                               double margin, const Context& context);
// Random points of slice space, `margin` inside the domain, and where they are in index space.
struct SlicePoints {
  std::vector<Vec3> uvw;
  std::vector<Vec4> index;
};
[[nodiscard]] SlicePoints slice_points(const Slice& slice, const std::array<uint32_t, 4>& dims, double margin,
                                       size_t count);
[[nodiscard]] double snr(std::span<const float> values, std::span<const Vec4> points, const test::Field4& f);

void report_paper_methods(const Report& report);
void report_relevant_points(const Report& report);
void report_relevant_points(const Report& report, const std::string& d4star_file, const std::string& cc_file);

} // namespace bccsplat::bench
