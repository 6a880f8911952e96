// SPDX-License-Identifier: Apache-2.0
// Frames of a volume on the source grid -> raw, NRRD or OpenVDB files.
#pragma once

#include <optional>
#include <string>

#include "readers/affine.h"
#include "readers/frame_reader.h"
#include "tool/handles.h"
#include "tool/output/nrrd_output.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"
#include "tool/view/slice_choice.h"

namespace bcc4 {

enum class ExportFormat { unset, raw, nrrd, vdb };

struct ExportOptions {
  ExportFormat format = ExportFormat::unset;
  std::optional<SampleBox> region; // none: all samples
  bool overwrite = false;
};

class Exporter {
 public:
  Exporter(const Volume& volume, uint32_t channel, const ExportOptions& options);
  void write_frame(const std::string& path, const Cut& where);
  // All frames in one file, time slowest; raw and NRRD.
  void write_series(const std::string& path, Progress& progress);
  // Returns the index that is written for a moment: the moment's, or of labels the nearest frame's. What
  // blends them makes up others.
  [[nodiscard]] double written_index(double index) const;
  // Returns the type of the values written.
  [[nodiscard]] Type type() const { return type_; }
  // Values that are missing and were written as 0, or as the background of OpenVDB.
  [[nodiscard]] uint64_t holes() const { return holes_; }

 private:
  [[nodiscard]] NrrdOutput header(bool series) const;
  [[nodiscard]] SampleBox region() const;
  [[nodiscard]] Affine affine() const;
  void append_frame(OutputFile& file, double index);
  void write_vdb_frame(const std::string& path, const Cut& where);

  const Volume& volume_;
  uint32_t channel_;
  ExportOptions options_;
  bccsplat_volume_info info_;
  bccsplat_channel_info channel_info_;
  Type type_;
  uint64_t holes_ = 0;
};

} // namespace bcc4
