// SPDX-License-Identifier: Apache-2.0
// Error against bytes of whole files: D4* at several scales, Cartesian, and every second frame left out.
#pragma once

#include "tests/bench/fit/fit_source.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

struct RatePoint {
  uint64_t bytes = 0;      // of the file
  double psnr = 0;         // dB at all source samples, peak: their range
  double largest = 0;      // error
  double kept_percent = 0; // sites stored, of the relevant Cartesian samples
};

// The series in a file and back, values in steps of `step` (0: the source's own), corrected to `bound` (0:
// not).
[[nodiscard]] RatePoint through_lattice(const FitSource& source, LatticeKind kind, double scale,
                                        double time_scale, double step, double bound);
// Every second frame in a Cartesian file, those between interpolated: linearly, or by Catmull-Rom splines.
[[nodiscard]] RatePoint through_half_the_frames(const FitSource& source, double step, bool cubic);

// Tables and plots of both, and what D4* is ahead of dropping frames at equal bytes.
void report_rates(const FitSource& source, const Report& report);

} // namespace bccsplat::bench
