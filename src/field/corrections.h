// Corrections of a file at its source samples (formats/bcc4.md, section 10), on the reading side: they keep
// the error bound that was asked for at import. Between samples a correction is a tent, so the field stays
// continuous; gradients are those of the field without them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "field/sample_grid.h"
#include "formats/bcc4/bcc4.h"

namespace bccsplat {

class Corrections {
 public:
  Corrections(std::shared_ptr<const Bcc4Reader> reader, int channel);

  // Adds to the samples of `grid`, index space at `frame`, what sample_grid made of them.
  void add_to_grid(double frame, const Grid& grid, float* values) const;
  // Adds to values at points (x, y, z, t) of index space. NaN stay, but at source samples that the file has
  // in spite of a hole. Returns how many of these there were.
  uint64_t add_to_points(std::span<const Vec4> points, std::span<float> values) const;
  // Smallest and largest correction near `frame`, 0 included.
  [[nodiscard]] std::array<float, 2> range(double frame) const;

 private:
  using List = std::vector<std::pair<uint64_t, float>>; // voxel, value; by rising voxel
  struct FrameList {
    List add; // to the value
    List set; // the value itself
  };
  struct Part { // a frame and how much it counts
    std::shared_ptr<const FrameList> list;
    float weight;
  };
  [[nodiscard]] std::shared_ptr<const FrameList> load(int64_t frame) const;
  [[nodiscard]] std::vector<Part> parts(double frame) const;

  std::shared_ptr<const Bcc4Reader> reader_;
  int channel_;
  std::array<int64_t, 4> n_{};
  mutable std::mutex mutex_;
  mutable std::vector<std::pair<int64_t, std::shared_ptr<const FrameList>>> recent_; // last used last
};

} // namespace bccsplat
