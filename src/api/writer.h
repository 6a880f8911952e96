// The writer behind the handle: options (writer_options.cpp), what is settled by the first data
// (writer_begin.cpp), frames, layers and fields (writer_data.cpp), from the fit into the file
// (writer_store.cpp), parts of a series (writer_part.cpp), a series that goes on (writer_append.cpp), the
// calls of the C ABI (writer.cpp).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/handles.h"
#include "api/structs.h"
#include "fit/coefficient_layers.h"
#include "fit/fit.h"
#include "store/round_trip.h"
#include "store/series_part.h"

namespace bccsplat::api {

enum class Feeding { nothing, frames, layers };

// What a finished channel adds to the counts of a report, and a finished file to its bytes.
void add_counts(const FitChannelReport& channel, uint64_t cc_samples, SourceType type,
                bccsplat_writer_report& report);
void add_bytes(const VolumeInfo& info, const Bcc4Report& written, bccsplat_writer_report& report);

// A file that is continued without its frames being given again.
struct Continued {
  std::shared_ptr<const Bcc4Reader> old;
  int32_t slabs = 0; // copied
};

} // namespace bccsplat::api

// Fit and container are made when the first data come: only then the source's precision may be known.
struct bccsplat_writer : bccsplat::api::Counted {
  bccsplat_writer(bccsplat_device* owner, const bccsplat_writer_options& options);
  void begin(bccsplat::api::Feeding kind, uint32_t channel, bccsplat::SourceType first_type);
  void add_frame(uint32_t channel, double time, const bccsplat_box* boxes, uint64_t count);
  void add_layer(uint32_t channel, int64_t layer, std::span<const float> samples);
  void add_field(uint32_t channel, bccsplat_field_fn field, void* user);
  void begin_continued(const bccsplat_series_part& options);
  bccsplat_writer_report finish();
  void check_channel(uint32_t channel) const;
  // Runs a step; after a failure the writer is of no use any more.
  void require_open() const {
    if (finished) bccsplat::fail(bccsplat::Code::wrong_state, "writer: finished already");
    if (broken) bccsplat::fail(bccsplat::Code::wrong_state, "writer: an earlier call failed; release it");
  }
  template<class Step> void step(const Step& body) {
    require_open();
    broken = true;
    body();
    broken = false;
  }

  bccsplat::api::Ref<bccsplat_device> device;
  bccsplat::Progress progress;
  std::unique_ptr<bccsplat::ByteSink> sink;
  bccsplat::VolumeInfo initial;
  bccsplat::FitOptions fit_options;
  std::vector<bccsplat_channel_options> channels; // strings not to be used: copied to `initial`
  bccsplat::api::Feeding feeding = bccsplat::api::Feeding::nothing;
  bool finished = false, broken = false;
  std::vector<double> times;
  std::vector<uint64_t> added; // frames or layers, per channel
  std::unique_ptr<bccsplat::Bcc4Writer> container;
  std::unique_ptr<bccsplat::Fit> fit;
  std::optional<bccsplat::Context> context;
  double abs_error = 0, psnr = 0;
  int32_t measure = 0, partial = 0, ends = 0;
  std::string path;                                // of the file; empty: a stream
  bool coefficients = false, given_up = false;     // given_up: measuring
  std::unique_ptr<bccsplat::RoundTrip> round_trip; // null: nothing is measured
  std::vector<bccsplat::Range> source_ranges;      // once finished
  std::optional<bccsplat::SeriesPart> part;        // none: the whole series
  std::optional<bccsplat::api::Continued> continued;

 private:
  // One channel between fit and container, when coefficients are stored.
  struct Prefiltered {
    Prefiltered(const bccsplat::Lattice4& lattice, const bccsplat::Quantiser& quantiser, float threshold,
                const std::string& kernel, int32_t samples, int32_t first, int32_t end)
        : maker(lattice, quantiser, threshold, kernel, samples, first, end) {}
    bccsplat::CoefficientLayers maker;
    std::vector<bccsplat::BrickLayer> slab;
    int32_t next_slab = 0;
  };
  std::vector<std::unique_ptr<Prefiltered>> prefiltered;
  std::vector<bccsplat::PartWrite> writes; // of a part
  bccsplat::PartWrite now;                 // what is under way, but for the frame

  void begin_part(const bccsplat_series_part& options);
  [[nodiscard]] std::vector<uint32_t> measured_frames() const;
  void store_residuals(int channel, uint32_t frame, const bccsplat::FrameResiduals& residuals);
  void describe_part(const bccsplat::FitReport& result);
  [[nodiscard]] bool stores_slab(int32_t slab) const {
    return !part || (slab >= part->first_slab && slab < part->end_slab);
  }

  void make_container();
  [[nodiscard]] int32_t lead() const; // of a series of frames
  [[nodiscard]] uint32_t fingerprint() const;
  [[nodiscard]] uint32_t series_fingerprint() const;
  [[nodiscard]] bccsplat::Bcc4WriterOptions appended() const;
  void read_times(const bccsplat_series_part& options);
  void check_continues(const bccsplat::VolumeInfo& was) const;
  void copy_continued();
  void add_continued(bccsplat::FitReport& result);
  [[nodiscard]] bool measuring_required() const {
    return abs_error > 0 || psnr > 0 || measure == BCCSPLAT_MEASURE_ALL;
  }
  void start_measuring(bool frames_known);
  // Runs a step of it. Measuring that is only nice to have ends where memory is short or the lattice has no
  // such kernel.
  template<class Body> void measuring(const Body& body) {
    try {
      body();
    } catch (const bccsplat::Error& e) {
      if (measuring_required() ||
          (e.code() != bccsplat::Code::memory_budget && e.code() != bccsplat::Code::unsupported))
        throw;
      round_trip.reset();
      given_up = true;
    }
  }
  void take_layers(int32_t slab, int channel, std::span<const bccsplat::BrickLayer> layers);
  void store_slab(int32_t slab, int channel, std::span<const bccsplat::BrickLayer> layers);
  void check_bounds(const bccsplat::FitReport& result) const;
};
