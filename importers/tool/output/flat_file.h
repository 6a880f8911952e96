// SPDX-License-Identifier: Apache-2.0
// Formats that are a header, the values as they are in memory, little-endian, and perhaps an end.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tool/output/byte_sink.h"
#include "tool/output/volume_file.h"

namespace bcc4 {

[[nodiscard]] std::unique_ptr<VolumeFile> create_flat(std::unique_ptr<ByteSink> file, Type type,
                                                      const std::string& head, std::string tail = "");

} // namespace bcc4
