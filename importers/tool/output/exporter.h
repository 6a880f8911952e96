// SPDX-License-Identifier: Apache-2.0
// Frames of a volume on the source grid -> files of any format that the tool writes.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "readers/affine.h"
#include "readers/frame_reader.h"
#include "tool/handles.h"
#include "tool/output/export_format.h"
#include "tool/output/stored_sites.h"
#include "tool/progress.h"
#include "tool/view/slice_choice.h"

namespace bcc4 {

struct ExportOptions {
  ExportFormat format = ExportFormat::unset;
  std::optional<SampleBox> region; // none: all samples
  int32_t motion = BCCSPLAT_MOTION_DEFAULT;
  bool overwrite = false, quiet = false;
};

class Exporter {
 public:
  // `sites`: of the same file and channel.
  Exporter(const Volume& volume, uint32_t channel, const ExportOptions& options, StoredSites sites);
  void write_frame(const std::string& path, const Cut& where);
  // All frames in one file, time slowest, of a format that holds several.
  void write_series(const std::string& path, Progress& progress);
  // Returns the index that is written for a moment: the moment's, or of labels the nearest frame's. What
  // blends them makes up others.
  [[nodiscard]] double written_index(double index) const;
  // Returns the type of the values written.
  [[nodiscard]] Type type() const { return type_; }
  // Values that are missing and were written as 0, or as the background of OpenVDB.
  [[nodiscard]] uint64_t holes() const { return holes_; }

 private:
  [[nodiscard]] VolumeOutput description() const;
  [[nodiscard]] SampleBox region() const;
  [[nodiscard]] Affine affine() const;
  // Hands over the values of a frame, or of a region of it, some planes at a time.
  void sample_frame(double index, const std::optional<SampleBox>& region,
                    const std::function<void(std::span<const float> values)>& take);
  void append_frame(VolumeFile& file, const VolumeOutput& output, double index);
  void write_vdb_frame(const std::string& path, const Cut& where);

  const Volume& volume_;
  uint32_t channel_;
  ExportOptions options_;
  StoredSites sites_;
  bccsplat_volume_info info_;
  bccsplat_channel_info channel_info_;
  Type type_;
  uint64_t holes_ = 0;
};

} // namespace bcc4
