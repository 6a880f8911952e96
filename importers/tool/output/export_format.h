// SPDX-License-Identifier: Apache-2.0
// The formats that volumes are written in: by name, by suffix, and what makes a file of each.
#pragma once

#include <memory>
#include <string>

#include "tool/options.h"
#include "tool/output/volume_file.h"

namespace bcc4 {

enum class ExportFormat : uint8_t { unset, raw, nrrd, vdb, nifti, netcdf, vti, tiff };

// Returns what the suffix of a name says; unset for others.
[[nodiscard]] ExportFormat format_of_suffix(const std::string& name);
// Returns the suffix of files that export names itself.
[[nodiscard]] const char* suffix_of(ExportFormat format);
[[nodiscard]] Choices<ExportFormat> export_formats();
// Throws for a format that this build cannot write; `option` is what asked for it.
void require_format(ExportFormat format, const std::string& option);
// Tells that samples are uneven along an axis where the format has no place for their coordinates.
void warn_of_uneven_samples(ExportFormat format);
// Can a file hold several frames?
[[nodiscard]] bool holds_series(ExportFormat format);

// Makes a file of any format but OpenVDB. What the format has no place for is warned of unless `quiet`.
[[nodiscard]] std::unique_ptr<VolumeFile> create_volume_file(ExportFormat format, const std::string& path,
                                                             const VolumeOutput& output, bool overwrite,
                                                             bool quiet);

} // namespace bcc4
