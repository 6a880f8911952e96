// SPDX-License-Identifier: Apache-2.0
// TIFF stacks, a page for each plane, that ImageJ and Fiji open as a hyperstack (libtiff, in its module).
#pragma once

#include <memory>
#include <string>

#include "tool/output/volume_file.h"

namespace bcc4 {

// Writes to `path`; `name` is what errors call the file. Whoever calls takes away what is not finished.
[[nodiscard]] std::unique_ptr<VolumeFile> create_tiff(const std::string& path, const std::string& name,
                                                      const VolumeOutput& output);

} // namespace bcc4
