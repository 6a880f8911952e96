// SPDX-License-Identifier: Apache-2.0
// Files that the tool makes of a series, and moments of them, as the library gives them.
#pragma once

#include <string>

#include "motion/box.h"
#include "tests/bench/fit/tool_import.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {

// A volume that nobody has looked at yet, one thread.
class StoredMoments {
 public:
  explicit StoredMoments(const std::string& path);

  // On the samples of the source; index: 0 at the first frame, 1 at the second.
  [[nodiscard]] motion::Box moment(double index, bccsplat_motion motion = BCCSPLAT_MOTION_DEFAULT) const;
  // CPU seconds of the slice alone.
  [[nodiscard]] double seconds(double index, bccsplat_motion motion = BCCSPLAT_MOTION_DEFAULT) const;

 private:
  [[nodiscard]] Handle<bccsplat_slice> slice(double index, bccsplat_motion motion) const;

  Handle<bccsplat_device> device_;
  Handle<bccsplat_volume> volume_;
};

// CPU seconds of moments of a file: the first one, and one half a frame on, before the last
// frame.
struct MomentSeconds {
  double first = 0, next = 0;
};
[[nodiscard]] MomentSeconds moment_seconds(const std::string& path, double index, double last);
// The same of a moment that follows the motion, of an interval that was looked at before.
[[nodiscard]] double following_seconds(const std::string& path, double index);
// CPU seconds of four frames, each a moment of its own, from a volume that nobody has looked at yet.
[[nodiscard]] double four_frames_seconds(const std::string& path, double index, double last);

} // namespace bccsplat::bench
