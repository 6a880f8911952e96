// SPDX-License-Identifier: Apache-2.0
// All that a writer has to be told about a series, chosen where nobody says it.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "choose/settle.h"

namespace bccsplat::series {

// What is asked for beside the settings of a writer, which are kept where they are not at their defaults. The
// plan finds out itself what of the store and the lattice is open.
struct SeriesWish : Unsettled {
  std::optional<uint32_t> levels; // none: by the size of the frames
  std::set<std::string> own_air;  // channels whose air was said
  std::vector<uint32_t> kinds;    // by channel: labels or quantities, as the file has to say; 0: as found
};

class SeriesPlan {
 public:
  // Reads the series and tries codings on a sample of it.
  SeriesPlan(FrameReader& reader, const Device& device, WriterSettings settings, const SeriesWish& wish,
             Watch& watch);
  SeriesPlan(const SeriesPlan&) = delete;
  SeriesPlan& operator=(const SeriesPlan&) = delete;

  // The options of the writer, until refine().
  [[nodiscard]] const bccsplat_writer_options& options() const { return options_->options; }
  // What was chosen and why.
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const std::string& json() const { return json_; }
  // After a writer missed the PSNR; false: nothing is left to try.
  [[nodiscard]] bool refine();

 private:
  void make_options();
  void choose(FrameReader& reader, const Device& device, const SeriesWish& wish, Watch& watch);

  SeriesDescription series_;
  WriterSettings settings_;
  std::vector<uint32_t> kinds_;
  std::vector<ChannelScan> scans_;
  std::optional<ChosenOptions> options_;
  std::string text_, json_;
  size_t missed_ = 0;
};

} // namespace bccsplat::series
