// SPDX-License-Identifier: Apache-2.0
// Writes an OpenVDB grid into a stream; the one file of the tool that knows OpenVDB.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "tool/output/vdb_output.h"

namespace bcc4 {

// Values are x fastest; `path` is for errors. The stream tells of a full disk.
void write_vdb_grid(std::ostream& stream, const std::string& path, const VdbOutput& output,
                    std::span<const float> values);

} // namespace bcc4
