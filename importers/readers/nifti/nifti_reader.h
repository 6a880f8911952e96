// SPDX-License-Identifier: Apache-2.0
// NIfTI-1 and NIfTI-2 images in one file (.nii, .nii.gz) or two (.hdr and .img), 3D or 4D. Format: nifti1.h
// and nifti2.h of the NIfTI DFWG.
#pragma once

#include <memory>
#include <string_view>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// Returns whether the first bytes of a file, unpacked, 352 or all there are, look like one.
[[nodiscard]] bool is_nifti(std::string_view start);
// Returns whether they look like a header of ANALYZE 7.5, from which NIfTI was made.
[[nodiscard]] bool is_analyze(std::string_view start);

// The fourth axis is time unless xyzt_units say hertz, ppm or radians. scl_slope 0 means no scaling.
[[nodiscard]] std::unique_ptr<FrameReader> open_nifti(const Sequence& sequence, const ReaderOptions& options);

} // namespace bcc4
