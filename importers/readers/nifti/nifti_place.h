// SPDX-License-Identifier: Apache-2.0
// Where the voxels of a NIfTI file lie.
#pragma once

#include <string>

#include "readers/frame_reader.h"
#include "readers/nifti/nifti_header.h"
#include "readers/reader_options.h"

namespace bcc4 {

// Takes the sform where there is one that spans a volume, else the qform, else the voxel sizes alone. Notes
// say which one was passed over, and that the two have left and right on different sides.
void set_affine(SeriesDescription& d, const NiftiHeader& h, const std::string& path,
                const ReaderOptions& options);

} // namespace bcc4
