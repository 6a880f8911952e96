// SPDX-License-Identifier: Apache-2.0
// The pictures that one command makes: which slice, turned how far, from which of the cameras, and
// under which name.
#pragma once

#include <string>
#include <vector>

#include "tool/handles.h"
#include "tool/view/camera_file.h"
#include "tool/view/render_arguments.h"

namespace bcc4 {

struct Picture {
  Cut where;
  double turn = 0;   // degrees about the vertical, beyond the camera's own
  size_t camera = 0; // of a camera file
  std::string path;
};

// --frames, --turntable (together: both advance), --sweep or the cameras of a camera file (cameras > 1, alone
// or one for each of
// --frames); else a single picture.
[[nodiscard]] std::vector<Picture> picture_sequence(const Volume& volume, const RenderArguments& arguments,
                                                    size_t cameras);

} // namespace bcc4
