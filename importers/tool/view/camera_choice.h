// SPDX-License-Identifier: Apache-2.0
// The camera of pictures, and what they share with other programs, as the options say.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "tool/view/camera_file.h"
#include "tool/view/host_things.h"
#include "tool/view/render_arguments.h"

namespace bcc4 {

struct CameraChoice {
  std::optional<CameraFile> file;
  int32_t projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  std::array<uint32_t, 2> size{512, 512};
};

// Reads what is shared with other programs; refuses options that it leaves without a meaning.
[[nodiscard]] HostThings host_things(const RenderArguments& arguments);
[[nodiscard]] CameraChoice choose_camera(const RenderArguments& arguments, const HostThings& host);

} // namespace bcc4
