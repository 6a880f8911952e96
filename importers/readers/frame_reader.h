// SPDX-License-Identifier: Apache-2.0
// What every reader of a series gives (series/frame_reader.h), and frames of files that are dense arrays.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "readers/value_type.h"
#include "series/frame_reader.h"

namespace bcc4 {

enum class AxisRole : uint8_t { x, y, z, t, component };

struct FileAxis {
  AxisRole role;
  uint64_t size;
};

// Makes a frame of one dense box over `bytes`, the values of one frame along `axes`, fastest first: an axis
// of time does not count, and of an axis of components the one asked for is taken.
[[nodiscard]] Frame dense_frame(Type type, std::shared_ptr<const Bytes> bytes,
                                const std::vector<FileAxis>& axes, uint64_t component = 0);

} // namespace bcc4
