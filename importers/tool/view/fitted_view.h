// SPDX-License-Identifier: Apache-2.0
// The camera of pictures that nobody gave one: from the side that people look at first, and filled by what is
// seen. All moments of a file have the same one, in whatever order and by however many commands they are
// drawn, and so have all turns about the vertical.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "tool/handles.h"
#include "tool/view/picture_sequence.h"
#include "tool/view/render_arguments.h"
#include "tool/view/transfer_function.h"

namespace bcc4 {

class FittedView {
 public:
  using Bounds = std::array<double, 6>; // of the world: x0 y0 z0 x1 y1 z1

  // What is given must outlive it. function: what is seen by.
  FittedView(const Volume& volume, uint32_t channel, const RenderArguments& arguments,
             TransferFunction function, int32_t projection, const std::array<uint32_t, 2>& size,
             const std::vector<Picture>& pictures);

  // slice: any of the picture's.
  [[nodiscard]] bccsplat_camera camera(const Slice& slice, const Picture& picture);
  // The middle of what is seen of the file, in the world. cut: makes a slice of the picture, where it takes
  // one.
  [[nodiscard]] std::array<double, 3> middle(const Picture& picture, const std::function<Slice()>& cut);
  // Has this box seen as well.
  void also_show(const Bounds& box) { beside_ = box; }
  // The box around what is seen at some moments of the file, in slices of the picture's shape; none: all are
  // damaged.
  [[nodiscard]] std::optional<Bounds> seen_of_series(const Cut& shape) const;

 private:
  [[nodiscard]] Bounds seen(const Slice& slice) const;
  // Has the same of all moments of a series found, once.
  void find_seen(const Picture& picture);

  const Volume& volume_;
  uint32_t channel_;
  const RenderArguments& arguments_;
  TransferFunction function_;
  std::array<uint32_t, 2> size_;
  bool several_planes_; // that are no moments
  bccsplat_fit fit_ = sized<bccsplat_fit>();
  std::optional<Bounds> bounds_, beside_;
};

// The box around two.
[[nodiscard]] FittedView::Bounds united(const FittedView::Bounds& a, const FittedView::Bounds& b);

// What is seen of a channel: what the function shows, or what lies within isosurfaces.
[[nodiscard]] TransferFunction seen_function(const RenderArguments& arguments,
                                             const std::optional<TransferFunction>& chosen,
                                             const bccsplat_look& look, double air);

} // namespace bcc4
