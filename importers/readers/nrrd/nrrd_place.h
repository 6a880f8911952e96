// SPDX-License-Identifier: Apache-2.0
// Where the samples of a NRRD file lie: in the world by directions, spacings and the ends of axes, along one
// axis by the last two.
#pragma once

#include <optional>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/nrrd/nrrd_header.h"
#include "readers/reader_options.h"

namespace bcc4 {

struct AxisPlace {
  std::optional<double> step, first; // the distance of samples, and the place of the first one
};
// An axis min or max is a place of a node, or the border of a cell, half a step outside its sample.
// `cells`: what the samples are where neither the centering nor the ends and the spacing tell.
[[nodiscard]] AxisPlace axis_place(const NrrdAxis& axis, bool cells);

// Sets the affine, where it comes from, coordinates of uneven axes, the unit and the space. Left-handed
// spaces become right-handed ones.
void set_affine(SeriesDescription& d, const NrrdHeader& h, const std::vector<AxisRole>& roles,
                const ReaderOptions& options);

} // namespace bcc4
