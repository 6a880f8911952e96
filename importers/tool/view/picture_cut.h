// SPDX-License-Identifier: Apache-2.0
// The slice that a picture needs: of the level that is fine enough, and no more of it than the camera sees.
#pragma once

#include <functional>
#include <vector>

#include "tool/view/host_things.h"
#include "tool/view/slice_choice.h"

namespace bcc4 {

struct PictureCut {
  Slice slice;
  bccsplat_camera camera;
  bccsplat_slice_info info;   // of the slice; what it took includes what told its level
  bccsplat_slice_info domain; // of what was to be cut, of which the camera may see a part
};

struct PictureSize {
  uint32_t width = 0, height = 0;
};

// Cuts for one picture after the other. Those of a turntable look at the same slice, which is cut once: what
// it took is told of the first picture.
class PictureCutter {
 public:
  // The volume and what is shared with a host must outlive it. choose: whether to ask what a picture needs,
  // of files with coarser levels; else it is cut as told.
  PictureCutter(const Volume& volume, uint32_t channel, bool choose, const bccsplat_render_options& options,
                const PictureSize& size, const HostThings& host)
      : volume_(volume), channel_(channel), choose_(choose), options_(options), size_(size), host_(host) {}

  // The camera is made for any slice of the picture.
  [[nodiscard]] PictureCut cut(const Cut& where, const std::function<bccsplat_camera(const Slice&)>& camera);

 private:
  struct Kept {
    Cut cut;
    Slice slice;
  };
  // Returns the slice, and in `info` what it is and took.
  Slice slice_at(const Cut& cut, bccsplat_slice_info& info);

  const Volume& volume_;
  uint32_t channel_;
  bool choose_;
  bccsplat_render_options options_;
  PictureSize size_;
  const HostThings& host_;
  std::vector<Kept> kept_; // of the last picture: what told its level, and what was drawn
};

} // namespace bcc4
