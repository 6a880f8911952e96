// SPDX-License-Identifier: Apache-2.0
// What bccsplat_slice_create takes of a file as people have it, which the tool made of raw frames.
#pragma once

#include <vector>

#include "tests/bench/fit/fit_source.h"
#include "tests/bench/moments/moments_series.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// All frames, as the tool reads them.
[[nodiscard]] FitSource source_of(const MomentSeries& series);

// Rows of a file that `bcc4 import` made without options and of one of samples: a frame, the moment half way
// to the next one, the same where nothing follows, and a box of it of a quarter of the edges, each from a
// volume that has been opened but not looked at, on one thread. Last the plain way: a frame out of gzip -6.
void slice_rows(const Row& head, const MomentSeries& series, std::vector<Row>& rows);

} // namespace bccsplat::bench
