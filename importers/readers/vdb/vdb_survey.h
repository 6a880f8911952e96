// SPDX-License-Identifier: Apache-2.0
// What the files of an OpenVDB series hold: its grids, where each first appears, how far their voxels reach.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "readers/file_times.h"
#include "readers/reader_options.h"
#include "readers/vdb/vdb_grid.h"

namespace bcc4 {

using VoxelOffset = std::array<int32_t, 3>;

// A grid that becomes a channel. A file that does not have it is a frame where it is empty.
struct SurveyedGrid {
  std::string name;
  std::optional<VdbGridInfo> info{}; // of the first file that has it
  std::vector<bool> present{};       // by file
  std::vector<uint64_t> active{};    // voxels by file, as far as they are known
  std::string first_absent{};        // file
};

class VdbSurvey {
 public:
  explicit VdbSurvey(const ReaderOptions& options);
  // Adds the next file. Throws for grids that do not go with those before.
  void add(VdbFile& file);
  // Throws for a series without a grid that can be read, and for grids that no file has. `first`: its file.
  void finish(VdbFile& first);

  [[nodiscard]] const std::vector<SurveyedGrid>& grids() const { return grids_; }
  [[nodiscard]] const VdbGridInfo& reference() const { return *reference_; }
  [[nodiscard]] const VdbBounds& bounds() const { return bounds_; } // of the active voxels of all files
  [[nodiscard]] const std::vector<VoxelOffset>& offsets() const { return offsets_; } // by file
  [[nodiscard]] const std::vector<FileTime>& times() const { return times_; }
  [[nodiscard]] size_t empty_frames() const { return empty_frames_; }
  [[nodiscard]] bool level_sets() const { return level_sets_; }
  [[nodiscard]] bool fog() const { return fog_; }
  // What was chosen, what is left out, and where a grid is empty because a file lacks it.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  void choose_grids(VdbFile& file);
  void note_others(VdbFile& file, const std::vector<std::string>& names);
  void check_grid(const SurveyedGrid& grid, const VdbGridInfo& info, const std::string& path) const;

  bool chosen_, fog_; // by --grid; level sets as fog
  std::vector<SurveyedGrid> grids_;
  std::optional<VdbGridInfo> reference_;
  VdbBounds bounds_;
  std::vector<VoxelOffset> offsets_;
  std::vector<FileTime> times_;
  std::map<std::string, std::string> others_; // grids left out, and why
  std::string choice_, first_file_;
  size_t files_ = 0, empty_frames_ = 0;
  bool level_sets_ = false;
};

} // namespace bcc4
