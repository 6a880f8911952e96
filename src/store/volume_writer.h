// SPDX-License-Identifier: Apache-2.0
// A volume in, a file out: the pipeline of a writer, which owns the order of its calls.
//
//   frames, or layers, or a field
//     -> LevelFit          at each level slabs of lattice samples, or of coefficients, where those are stored
//     -> Bcc4Writer        the file, with a journal, as a part, or behind the slabs of an older one
//     -> Measuring         what a reader will get, against the frames; corrections back into the file
//
// Files: volume_writer.cpp has what is settled before the first data, volume_writer_input.cpp the ways in,
// volume_writer_output.cpp the way from the fit into the file, volume_writer_live.cpp what can be looked at
// while it is written, volume_writer_finish.cpp how the series ends.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "fit/fit.h"
#include "formats/bcc4/write/writer.h"
#include "store/continuation.h"
#include "store/field_samples.h"
#include "store/journal_options.h"
#include "store/level_fit.h"
#include "store/level_frames.h"
#include "store/measuring.h"
#include "store/series_part.h"
#include "store/settings.h"
#include "store/write_report.h"

namespace bccsplat {

// Where the sites of a layer are: origin + step * (i, j, k) in index space, at a frame index.
struct LayerGeometry {
  int coset = 0;
  FieldGrid sites;
  int64_t layers = 0; // of the series
};

// The errors of a measured frame, or of the series.
struct MeasuredErrors {
  uint64_t frame = 0; // of the series: the one of the largest difference
  double peak = 0;    // range of the channel's source
  SampleErrors errors;
};

class VolumeWriter {
 public:
  // Throws where the settings contradict each other or a file that is there already. stream: null for a file
  // at settings.path. What the context refers to outlives the writer.
  VolumeWriter(WriterSettings settings, std::unique_ptr<ByteSink> stream, const Context& context);
  VolumeWriter(const VolumeWriter&) = delete;
  VolumeWriter& operator=(const VolumeWriter&) = delete;

  // Data of a channel, in order: frames, or layers, or a field. What is refused for its arguments, its place
  // in the order of calls or its values leaves the writer as it was; after a failure of the work itself
  // (files, memory, cancelling, a bound, a field that gives up) the writer is of no use.
  void add_frame(uint32_t channel, double time, std::span<const FrameBox> boxes);
  void add_layer(uint32_t channel, int64_t layer, std::span<const float> samples);
  void add_field(uint32_t channel, const Field& field);
  // Completes the file and gives it its name. Refused while frames or layers are missing.
  WriteReport finish();
  // The same of a series that ends sooner than was said: with what every channel has been given.
  WriteReport finish_short();

  // Set what the file says of itself, at any time before finish.
  void set_times(double first, double step);
  // Throws limit_exceeded where the texts of all attributes and sources take more than 32 MiB.
  void set_attribute(const std::string& key, const std::string& value);
  void add_source(SourceInfo source);

  // Throws not_found.
  void require_channel(uint32_t channel) const;
  [[nodiscard]] LayerGeometry layer_geometry(int64_t layer) const;
  // The frames that must be given, begin and end.
  [[nodiscard]] std::array<uint64_t, 2> given_frames() const;
  // The samples of each that a block needs; all of them where all of space is written.
  [[nodiscard]] Region given_samples() const;
  // After finish; index -1: of the series, else of the frame measured as that one.
  [[nodiscard]] MeasuredErrors measured(uint32_t channel, int64_t index) const;
  // After finish: what the host should know of its options.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  enum class Input : uint8_t { none, frames, layers };
  enum class State : uint8_t { open, failed, finished };

  // Settled before the first data.
  void check_settings() const;
  void check_periodic() const;
  void check_labels() const;
  void begin_info();
  void require_wavelet_types() const;
  void leave_rounding();
  void begin_part();
  void begin_block();
  // Throws wrong_state where the file or journal to go on with is of another series, before it is touched.
  void require_same_series();
  void require_continued_file() const;
  [[nodiscard]] int32_t predicted_layers() const;
  // Planes outside each face: of frames, which make up for the mirrors behind them (fit/beyond/face_table.h),
  // and of layers and fields, which do not.
  static constexpr int32_t frame_planes = 2, given_planes = 4;
  [[nodiscard]] Int3 outside_planes(int32_t wanted, int level = 0) const;
  [[nodiscard]] int levels() const;
  // Returns the options of the fits of all levels, level 0 first.
  [[nodiscard]] std::vector<FitOptions> level_options() const;
  void begin_levels();
  [[nodiscard]] LayerUse layer_use() const;
  // Returns what is made of the series; null: all of it.
  [[nodiscard]] const SeriesPart* part_made() const {
    if (continued_) return &continued_->rest();
    return part_ ? &*part_ : nullptr;
  }
  [[nodiscard]] bool is_block() const { return part_ && !part_->fit.counted.all_space(); }
  // Returns whether a field far from air may get another base, which follows from all of the series.
  [[nodiscard]] bool knows_base() const { return !part_made() && !settings_.fixed_predictions; }

  // The ways in.
  void require_open() const;
  void take_text(uint64_t bytes, uint64_t replaced);
  void require_input(Input input) const;
  // Settles what the first data settle, and checks what that is needed for. A step that is refused undoes it.
  template<class Step> void prepare(const Step& step) {
    const bool first = fits_.empty();
    Settled settled;
    if (first) settled = {initial_, fit_options_};
    try {
      step();
    } catch (const Error& e) {
      if (first) unsettle(settled);
      if (!is_refusal(e.code())) state_ = State::failed;
      throw;
    } catch (...) {
      state_ = State::failed;
      throw;
    }
  }
  // A step that fails leaves the writer failed.
  template<class Step> void run_step(const Step& step) {
    state_ = State::failed;
    step();
    state_ = State::open;
  }
  // The state that begin_input() changes.
  struct Settled {
    VolumeInfo info;
    FitOptions options;
  };
  void unsettle(const Settled& settled);
  [[nodiscard]] static bool is_refusal(Code code);
  void begin_input(Input input, uint32_t channel, SourceType first_type);
  void begin_measuring(bool frames_known);
  void begin_measuring_levels();
  [[nodiscard]] std::vector<uint32_t> frames_to_measure() const;
  // Returns those frames of the list that the writer is given and counts.
  [[nodiscard]] std::vector<uint32_t> own_frames(std::vector<uint32_t> list) const;
  void check_time(uint64_t frame, double time) const;
  void require_layers() const;
  void check_boxes(uint64_t frame, std::span<const FrameBox> boxes) const;
  void report_added(uint64_t first, uint64_t end);

  // From the fit into the file.
  void store_slab(int32_t slab, const ChannelLevel& at, const SlabLayers& layers);
  void store_residuals(int channel, uint32_t frame, const FrameResiduals& residuals);
  void take_mask(int channel, uint32_t frame, std::vector<std::byte> runs);
  void store_masks();
  void make_container();
  // Writes what an unfinished file shows.
  void show_if_due();
  [[nodiscard]] uint32_t frames_to_show(int32_t layers) const;
  [[nodiscard]] VolumeInfo info_to_show(uint32_t frames, int32_t layers) const;
  [[nodiscard]] Bcc4WriterOptions container_options(const VolumeInfo& info) const;
  // Returns the checksum of what the bytes of a series depend on and the file does not tell.
  [[nodiscard]] uint32_t settings_checksum(std::optional<double> psnr) const;
  // Returns what must be equal for this writer to take over what an earlier one left.
  [[nodiscard]] uint32_t writer_checksum() const;

  // The steps that finish() adds.
  void check_end() const;
  void require_no_fewer(uint64_t frames) const;
  void check_times(uint32_t frames) const;
  [[nodiscard]] uint32_t frames_of_short() const;
  void shorten(uint32_t frames);
  [[nodiscard]] FitReport finish_fits();
  [[nodiscard]] FitReport report_of_fits() const;
  void complete_info(const FitReport& result);
  void describe_part(const FitReport& result);
  void tell_base(size_t c, ChannelInfo& channel) const; // of a field with corrections
  void describe_level_errors(const FitReport& result);
  void require_bounds(const FitReport& result) const;
  [[nodiscard]] TimeMap time_map(uint32_t frames) const;

  WriterSettings settings_;
  Context context_;
  std::unique_ptr<ByteSink> sink_; // until the container takes it
  JournalOptions journal_options_; // empty: no journal
  VolumeInfo initial_;             // what is known before the fit begins
  FitOptions fit_options_;
  State state_ = State::open;
  Input input_ = Input::none;
  uint64_t text_bytes_ = 0; // of attributes and sources
  std::vector<double> times_;
  std::vector<uint64_t> added_; // frames or layers, per channel

  [[nodiscard]] Fit& fit() { return fits_.back()->fit(); }
  [[nodiscard]] const Fit& fit() const { return fits_.back()->fit(); }
  std::vector<std::unique_ptr<LevelFit>>
      fits_;                                // the coarsest first, level 0 last; empty before the first data
  std::optional<LevelFrames> level_frames_; // as the fits
  std::unique_ptr<Bcc4Writer> container_;
  int32_t shown_slabs_ = 0;
  Measuring measuring_;
  std::vector<Range> source_ranges_; // once finished
  std::vector<std::string> warnings_;

  std::optional<SeriesPart> part_; // none: the whole series, or what continues a file
  std::optional<Continuation> continued_;
  // Masks of frames wait for what is written next: so the container is made as late as without them.
  struct WaitingMask {
    int channel;
    uint32_t frame;
    std::vector<std::byte> runs;
  };
  std::vector<WaitingMask> masks_;
  std::vector<PartWrite> writes_; // of a part
  PartWrite now_;                 // the write under way: trigger, channel, level and slab
};

} // namespace bccsplat
