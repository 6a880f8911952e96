// SPDX-License-Identifier: Apache-2.0
// Does the last frame of a series lead to the first, as of heart beats and climatologies? Does the last
// column of a frame, as where x is longitude?
#pragma once

#include <array>
#include <limits>
#include <optional>

#include "readers/frame_reader.h"
#include "series/watch.h"

namespace bcc4 {

// Differences between frames, root mean squares over some of their samples; of the channel that looks the
// least like one that goes round.
struct Turn {
  double last_to_first = 0;
  double to_next = 0; // the largest of some frames from the next one
  double across = 0;  // of frames half a series apart, the smallest of some
  double within = std::numeric_limits<double>::infinity(); // of columns: what varies in the first one; what
                                                           // is next to nothing leads anywhere

  // Noise alone would be as far from the next frame as from any other: of what moves, frames half a series
  // apart differ more.
  [[nodiscard]] bool leads_to_first() const {
    constexpr double about_alike = 1.25, moved = 1.5;
    return last_to_first <= about_alike * to_next && across >= moved * last_to_first && across > 0 &&
           within >= moved * last_to_first;
  }
};

// Reads some frames. None of series too short to tell, of fewer than six frames.
[[nodiscard]] std::optional<Turn> measure_turn(FrameReader& reader, Watch& watch);
// The same of the columns of a frame across x and across y; none of axes of fewer than 16 samples.
[[nodiscard]] std::array<std::optional<Turn>, 2> measure_round(FrameReader& reader, Watch& watch);

} // namespace bcc4
