// SPDX-License-Identifier: Apache-2.0
// What a voxel of a NIfTI file holds: a number, several (dim[5]), a colour or a complex number.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "readers/dense_series.h"
#include "readers/nifti/nifti_header.h"

namespace bcc4 {

struct NiftiValues {
  Type type = Type::f32;
  uint64_t parts = 1;               // that follow each other in a voxel
  std::vector<std::string> names{}; // of the parts, in order: red, green, blue; real, imaginary
  [[nodiscard]] bool complex() const { return !names.empty() && names[0] == "real"; }
  [[nodiscard]] bool colour() const { return !names.empty() && !complex(); }
};

// Throws for types that cannot be read.
[[nodiscard]] NiftiValues nifti_values(const NiftiHeader& header, const std::string& path);

// Opens complex numbers: of the real and the imaginary part, or of what --channel names, magnitude and phase
// (in radians) among them, a channel each. `kind` is what the parts are like.
[[nodiscard]] std::unique_ptr<FrameReader> open_complex(SeriesDescription description, DenseSeries series,
                                                        const ReaderOptions& options, const std::string& path,
                                                        const Channel& kind);

} // namespace bcc4
