// SPDX-License-Identifier: Apache-2.0
// The slice that a picture needs: of the level that is fine enough, and no more of it than the camera sees.
#pragma once

#include <functional>

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

// The camera of a picture is made for any slice of it. choose: whether to ask what the picture needs, of
// files with coarser levels; else it is cut as told.
[[nodiscard]] PictureCut cut_for_picture(const Volume& volume, const Cut& where, uint32_t channel,
                                         bool choose, const bccsplat_render_options& options,
                                         const PictureSize& size,
                                         const std::function<bccsplat_camera(const Slice&)>& camera);

} // namespace bcc4
