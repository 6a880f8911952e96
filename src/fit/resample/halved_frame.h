// SPDX-License-Identifier: Apache-2.0
// A frame at twice the distance of its samples: what a coarser level of a series is resampled from, so that
// all of the source is read and filtered once more, whatever the number of levels.
//
// The filter is that of the resampling, widened to the distances of the halved frame: what these hold passes,
// the rest is removed. The first and the last sample of an axis stay where they are; those between are evenly
// spread, at most two samples apart. Along a periodic axis all are evenly spread, the first one where it is.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "base/context.h"
#include "fit/axis/filter.h"
#include "fit/beyond/face_noise.h"
#include "fit/frame/frame.h"
#include "fit/frame/scan.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Relative to the air of its source; what was missing is filled.
struct HalvedFrame {
  std::vector<float> values; // of the box that is made, x fastest
  std::optional<Frame> frame;
  CellRanges cells;
  Reservation memory;
};

class FrameHalver {
 public:
  // dims: of the frames. halved: the axes along which they are. predicted: those beyond whose faces samples
  // are predicted (face_table.h); beyond the others they are mirror images, or along `turning` axes the
  // samples at the other face. local: what varies little around a large value is filtered as it is, to some
  // units in the last place, and not as the difference from the least of all samples.
  FrameHalver(const std::array<int64_t, 3>& dims, const AxisFlags& halved, const AxisFlags& predicted,
              const AxisFlags& turning = {}, bool local = false);

  [[nodiscard]] std::array<int64_t, 3> dims() const;
  // Lets a box of the halved frame, of whole cells, be all that is made and given of it from now on.
  void make_only(const Region& box) { made_ = box; }
  // Returns the samples of the frame that the box is made of, by whole cells, where faces are predicted as
  // usual. Not along axes that turn.
  [[nodiscard]] Region seen();
  // faces: how boldly samples are predicted. ringing: what the filter leaves up to this fraction of the
  // largest departure from air in its reach is air, and so is, unless this is 0, what it leaves where all of
  // the frame around are air, whatever that is. The result has the same bits for any number of threads and
  // however the frame is divided into boxes; what is air costs next to nothing.
  [[nodiscard]] HalvedFrame halve(const Frame& frame, const CellRanges& cells, const FaceLevels& faces,
                                  float ringing, const Context& context);

  // The filters along the axes.
  struct Tables {
    // One axis: what the samples of the halved frame are made of, and which samples are around each.
    struct Axis {
      FilterTable table;
      bool turns = false;
      std::vector<int32_t> sample;                // by weight of the table
      std::vector<std::array<int64_t, 2>> near;   // first and last, counted on beyond ends that turn
      std::vector<std::array<int64_t, 2>> inside; // by sample of the halved frame: samples it depends on
    };
    // Sixteen samples along x (resample_tile.h).
    struct BrickX {
      int64_t base = 0;
      std::array<int32_t, 16> index{};
      std::vector<float> weight;
      std::array<int64_t, 2> inside{};
    };
    std::array<int64_t, 3> from{}, to{}; // samples
    std::array<Axis, 3> axis;
    std::vector<BrickX> x;
    int64_t row_begin = 0, row_end = 0; // of a row with what is beyond its faces
  };

 private:
  [[nodiscard]] const Tables& tables_of(const FaceLevels& faces);

  std::array<int64_t, 3> from_;
  AxisFlags predicted_;
  bool local_;
  Lattice4 grid_; // of the halved samples
  Region made_;
  std::map<FaceLevels, Tables> tables_;
};

} // namespace bccsplat
