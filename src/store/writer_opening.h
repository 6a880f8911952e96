// SPDX-License-Identifier: Apache-2.0
// What a writer makes, settled by its options and then by its first data: a file, a part of a series, or what
// continues a finished file, which is opened here and nowhere else. Holds the settings, and what they ask of
// the fit and say in the file; needs nothing of the data but their type.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "base/context.h"
#include "fit/fit.h"
#include "formats/bcc4/read/reader.h"
#include "store/continuation.h"
#include "store/journal_options.h"
#include "store/measuring.h"
#include "store/series_part.h"
#include "store/settings.h"

namespace bccsplat {

class WriterOpening {
 public:
  // What the first data settle.
  struct Settled {
    VolumeInfo info; // what the file says of itself
    FitOptions fit;  // of level 0
  };

  // Throws where the settings contradict each other or the file or journal to go on with, before that is
  // touched. to_stream: there is no file at settings.path.
  WriterOpening(WriterSettings settings, bool to_stream, Measuring& measuring, const Context& context);

  // Settles how each channel is coded, and what frames, or layers, need. first_type: of the first data, which
  // are those of first_channel.
  void settle(bool frames, uint32_t first_channel, SourceType first_type);
  [[nodiscard]] const Settled& settled() const { return settled_; }
  // Takes back what data settled that were refused.
  void restore(Settled settled) { settled_ = std::move(settled); }
  // The series has fewer frames than was said.
  void shorten(uint32_t frames, const Lattice4& lattice);

  [[nodiscard]] const WriterSettings& settings() const { return settings_; }
  [[nodiscard]] uint32_t frames() const { return settings_.dims[3]; } // 0: as many as are given
  [[nodiscard]] VolumeInfo& info() { return settled_.info; }
  [[nodiscard]] const VolumeInfo& info() const { return settled_.info; }
  [[nodiscard]] const FitOptions& fit() const { return settled_.fit; }
  // Returns the options of the fits of all levels, level 0 first.
  [[nodiscard]] std::vector<FitOptions> level_options() const;

  // A file that is appended to; null: none.
  [[nodiscard]] const std::shared_ptr<const Bcc4Reader>& old() const { return old_; }
  // Lets go of it, as the new one is about to get its name: not every system replaces a file that is open.
  void close_old() { old_.reset(); }
  // Null, or how it is continued without its frames.
  [[nodiscard]] const Continuation* continued() const { return continued_ ? &*continued_ : nullptr; }
  // Null, or the part of a series that is made.
  [[nodiscard]] const SeriesPart* part() const { return part_ ? &*part_ : nullptr; }
  [[nodiscard]] bool is_block() const { return part_ && !part_->fit.counted.all_space(); }
  // Returns what is made of the series; null: all of it.
  [[nodiscard]] const SeriesPart* part_made() const { return continued_ ? &continued_->rest() : part(); }
  // Returns whether a field far from air may get another base, which follows from all of the series.
  [[nodiscard]] bool knows_base() const { return !part_made() && !settings_.fixed_predictions; }
  // Returns the slabs of a series on a lattice that stay as they are when more frames follow.
  [[nodiscard]] int32_t lasting_slabs(const Lattice4& lattice) const;

  [[nodiscard]] const JournalOptions& journal_options() const { return journal_options_; }
  // Returns the checksum of what the bytes of a series depend on and the file does not tell.
  [[nodiscard]] uint32_t checksum(std::optional<double> psnr) const;
  // Returns what must be equal for this writer to take over what an earlier one left.
  [[nodiscard]] uint32_t writer_checksum() const;

 private:
  void begin_info();
  void require_continued_file() const;
  void begin_part(Measuring& measuring, const Context& context);
  void plan_part(Measuring& measuring, const Context& context);
  void begin_block(const Context& context);
  void begin_journal();
  void settle_beyond();

  WriterSettings settings_;
  std::shared_ptr<const Bcc4Reader> old_;
  Settled settled_;
  std::optional<SeriesPart> part_;
  std::optional<Continuation> continued_;
  JournalOptions journal_options_; // empty: no journal
};

} // namespace bccsplat
