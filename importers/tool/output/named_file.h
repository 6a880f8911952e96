// SPDX-License-Identifier: Apache-2.0
// Files that libraries write by their path: under another name until they are whole.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tool/output/volume_file.h"

namespace bcc4 {

using CreateFile = std::function<std::unique_ptr<VolumeFile>(const std::string& path)>;
[[nodiscard]] std::unique_ptr<VolumeFile> create_named(const std::string& path, bool overwrite,
                                                       const CreateFile& create);

} // namespace bcc4
