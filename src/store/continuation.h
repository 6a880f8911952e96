// SPDX-License-Identifier: Apache-2.0
// A finished file whose series goes on: what new frames must agree with, and what of the old file stays.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/context.h"
#include "fit/fit.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/write/writer.h"
#include "store/series_part.h"
#include "store/settings.h"

namespace bccsplat {

// Throws unsupported where the series of the file at `path` is periodic.
void require_open_end(const VolumeInfo& was, const std::string& path);
// Throws wrong_state unless new frames can follow those of the file at `path`, which says `was` of itself.
// frames: of the series that goes on; 0: not known yet.
void require_continuable(const VolumeInfo& was, const VolumeInfo& now, uint32_t frames,
                         const std::string& path);

// A file that is continued without its frames being given again: only the frames come that the slabs behind
// its lasting ones depend on, and what is said about the series is put together from the old file and these.
class Continuation {
 public:
  // old: the file at settings.path; once it is closed nothing but slabs() and rest() may be asked. Throws,
  // saying why, where it cannot be continued by settings.part alone. options: of the longer series.
  Continuation(const Bcc4Reader& old, const WriterSettings& settings, FitOptions options);

  [[nodiscard]] const Lattice4& lattice() const { return lattice_; } // of the longer series
  [[nodiscard]] const SeriesPart& rest() const { return rest_; }     // what is left to do
  [[nodiscard]] int32_t slabs() const { return rest_.first_slab; }   // of a channel that are copied

  // Puts the slabs that stay, and the masks between them, where a writer of all frames puts them: in the
  // order of the old file.
  void copy_what_stays(Bcc4Writer& container, Progress& progress) const;
  // Returns whether the mask of a frame is among these.
  [[nodiscard]] bool has_mask(uint32_t frame, int channel) const {
    return std::pair(frame, channel) < masks_end_;
  }
  // Adds what the old file tells of its frames, and of the slabs that were copied, to the report of the rest.
  void add_to(FitReport& report, const Context& context) const;

 private:
  void find_places();
  // Counts of the sites of the slabs that stay, of each channel.
  [[nodiscard]] std::vector<LayerCounts> old_counts(const Context& context) const;

  [[nodiscard]] const VolumeInfo& info() const { return old_.info(); }

  const Bcc4Reader& old_;
  Lattice4 lattice_;
  SeriesPart rest_;
  std::optional<std::vector<LayerCounts>> told_; // of wavelets
  // Something that is copied, by where the old file has it. A mask that an earlier one shares has its place.
  struct Place {
    uint64_t offset;
    int32_t slab; // PartWrite::mask: none
    ChannelLevel at;
    uint32_t frame; // of a mask
  };
  std::vector<Place> slab_places_, mask_places_; // rising
  std::pair<uint32_t, int> masks_end_{};         // the first frame and channel whose mask is not copied
};

} // namespace bccsplat
