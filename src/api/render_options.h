// SPDX-License-Identifier: Apache-2.0
// What a caller says of a picture, checked and in the core's terms.
#pragma once

#include "bccsplat.h"

#include "scene/host_view.h"
#include "scene/picture.h"
#include "scene/trail.h"
#include "view/camera.h"

namespace bccsplat::api {

[[nodiscard]] inline Vec3 vec3(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

// These throw invalid_argument where a value is senseless. NULL options are the defaults; their callback is
// not looked at.
[[nodiscard]] Camera read_camera(const bccsplat_camera* camera);
[[nodiscard]] TransferFunction read_function(const bccsplat_transfer_function* function);
[[nodiscard]] AskedTrail read_trail(const bccsplat_trail* trail);
// Null: the defaults.
[[nodiscard]] Lights read_lights(const bccsplat_lights* lights);
void write_camera(const Camera& camera, bccsplat_camera* out);
// Tell the log, once per device, of what a host hardly meant.
void hint_at_camera(bccsplat_device& device, const Camera& camera);
void hint_at_options(bccsplat_device& device, const RenderOptions& options);
[[nodiscard]] RenderOptions read_render_options(const bccsplat_render_options* options);
// The same, with what the device draws by where the options do not say.
[[nodiscard]] RenderOptions read_render_options(const bccsplat_render_options* options,
                                                const bccsplat_device& device);
// The defaults of a device.
void use_device(RenderOptions& options, const bccsplat_device& device);
// Has a picture drawn into the texture of a frame that has one, by the view that it is seen by.
void use_target(RenderOptions& options, bccsplat_frame& frame, const HostView& view);
[[nodiscard]] bccsplat_backend drawn_by(const RenderStats& stats);

} // namespace bccsplat::api
