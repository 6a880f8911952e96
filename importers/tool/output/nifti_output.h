// SPDX-License-Identifier: Apache-2.0
// The header of NIfTI files: NIfTI-1, and NIfTI-2 where an axis has more than 32767 samples.
#pragma once

#include <string>
#include <vector>

#include "tool/output/volume_file.h"

namespace bcc4 {

struct NiftiText {
  std::string header;             // up to where the values begin
  std::vector<std::string> notes; // what the format has no place for
};
// The world is turned to what NIfTI has, x to the right, y forward, z up, where the source's space is known.
// sform and qform are the same, but for axes that no rotation makes: these have an sform alone.
[[nodiscard]] NiftiText nifti_header_text(const VolumeOutput& output);

} // namespace bcc4
