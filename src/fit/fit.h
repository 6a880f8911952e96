// SPDX-License-Identifier: Apache-2.0
// Streaming fit: frames of a Cartesian series, or layers of lattice samples, in; the relevant lattice samples
// out, slab by slab. Memory does not grow with the number of frames (but for 16 bytes each, their ranges).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "fit/beyond/face_noise.h"
#include "fit/direct_layer.h"
#include "fit/frame/frame.h"
#include "fit/frame/scan.h"
#include "fit/kept/histogram.h"
#include "fit/kept/layer.h"
#include "fit/kept/quantise.h"
#include "fit/resample/holes.h"
#include "lattice/lattice.h"
#include "points/series_block.h"
#include "points/slab_layers.h"
#include "points/values.h"

namespace bccsplat {

struct FitChannel {
  std::string name = "value"; // for error texts
  Quantiser quantiser;
  std::optional<double> air; // of frames, where the quantiser has only the nearest float; none: that of it
  // A site within this of air is dropped; 0: only where the stored code is that of air.
  float threshold = 0;
  // Ringing of the filter next to samples that are air is dropped up to this fraction of the largest
  // departure from air in its reach, and further away all of it (relevance.h says why); 0: it is kept like
  // anything else. Integers lose little by it, floats half.
  float ringing = 1.0f / 512;
  // The unit of values that wait for the filter in time (packed_block.h); 0: floats.
  float unit = 0;
  // NonFinite::clamp makes infinities the ends of this range; none: of the source's range so far.
  std::optional<Range> range;
};

// One of several fits of one series, each with frames of its own. Frames and layers keep the numbers they
// have in the whole series, and every layer comes out as from a fit of all of it.
struct FitPart {
  uint32_t first_given = 0, end_given = 0; // frames that are given
  SeriesBlock counted;                     // of these, the samples that enter the report
  int32_t first_layer = 0, end_layer = 0;  // layers handed out, by whole slabs
  int32_t first_own = 0, end_own = 0;      // of these, the layers that enter the report
  // The bricks of a block that are handed out, and those of them that enter the report. Layers have no other
  // bricks.
  LayerBricks bricks;
  Region halved; // of a block: the samples that coarser levels are made of, by whole cells of CellRanges
  // How many samples around those that a block resamples are looked at to tell, at any level, what is missing
  // far from data.
  int64_t masked = 0;
};

struct FitOptions {
  LatticeKind lattice = LatticeKind::d4star; // one frame: BCC (or 3D CC)
  std::array<uint32_t, 4> dims{1, 1, 1, 0};  // source samples; dims[3] = 0: as many frames as are given
  LatticeScales scales{1, 1, 1, 1};          // as in Lattice4::fit
  // Layers beyond each end of time, even, made of predicted frames (ends.h); 0: none, and frames beyond an
  // end are mirror images. Layers that are given are never more than those of the series.
  int32_t lead = 0;
  // The last frame leads to the first: frames beyond an end are those at the other one. Needs dims[3] > 0, no
  // lead and no part.
  bool periodic = false;
  // The same along axes of space: samples beyond a face are those at the other one. No margins there.
  AxisFlags turning{};
  // Planes outside both faces of each axis, even, made of predicted samples; 0: none, and samples beyond a
  // face are mirror images. Layers that are given hold them.
  Int3 margins{0, 0, 0};
  bool lowpass = false; // frames first lose what the lattice cannot hold (lowpass.h); not CC
  NonFinite nonfinite = NonFinite::error;
  bool masks = false; // holes of frames are told as masks of the source, not marked on the lattice
  // Planes of the lattice: with masks, sites further than that from all data are left out.
  int32_t mask_reach = 0;
  // How far holes of frames are filled. A bounded reach, which blocks need, takes no frame that is missing
  // altogether: it would be filled from those beside it.
  FillReach fill;
  int32_t slab_layers = 8;
  // What lies outside faces and beyond ends is predicted with the usual boldness, and frames are halved as
  // they are, whatever the data: blocks of a frame then need nothing of each other.
  bool fixed_predictions = false;
  int32_t lasting_layers = 0;  // the first ones, which are counted by themselves as well
  std::optional<FitPart> part; // none: all of the series; else dims[3] > 0, and frames, not layers, are given
  std::vector<FitChannel> channels{1};
};

// The lattice of a series of `frames`.
[[nodiscard]] Lattice4 lattice_of(const FitOptions& options, uint32_t frames);

// A lattice in samples of what frames were halved to, whose first and last ones are those of the frames.
[[nodiscard]] Lattice4 lattice_over(const std::array<int64_t, 3>& dims, Lattice4 lattice);
// Returns how far data are from samples whose sites are left out of what a mask tells; what is around a
// sample belongs to it for half a distance.
[[nodiscard]] std::array<int64_t, 3> mask_reach_of(const FitOptions& options, const Lattice4& lattice);

// Returns the samples, by whole cells of CellRanges, that the bricks a fit makes are resampled from; of
// frames that were halved to dims.
[[nodiscard]] Region seen_samples(const FitOptions& options, const Lattice4& lattice,
                                  const std::array<int64_t, 3>& dims);

// The samples of a frame that a fit of a block takes; of all others all of them.
struct FitScope {
  Region counted; // enter the report
  Region seen;    // beside these, what the layers are made of, by whole cells
  Region given;   // beside these, what decides what is missing there and how it is filled
};
// lattice: that of the options.
[[nodiscard]] FitScope scope_of(const FitOptions& options, const Lattice4& lattice);

// Layers slab * slab_layers .. of one channel, fewer than slab_layers only at the end; one by one each is
// what a slab is else. Slabs of a channel
// come in rising order, all of them, from the thread that called the Fit; of periodic frames those that need
// the last frames, the first ones, come last. Values are relative to air and
// exactly representable in the stored type.
using FitSink = std::function<void(int32_t slab, int channel, const SlabLayers& layers)>;

// Takes which samples of a frame are missing (formats/bcc4/coding/mask_runs.h), where any is, when the frame
// is given.
using MaskSink = std::function<void(int channel, uint32_t frame, std::vector<std::byte> runs)>;

// Counts of the sites of layers.
struct LayerCounts {
  uint64_t sites_total = 0, sites_kept = 0;
  uint64_t holes = 0;      // of the sites kept
  uint64_t clamped = 0;    // sites whose value the stored type could not hold
  SampleHistogram samples; // of the sites kept that are no holes

  void add(const LayerCounts& other); // of an equal quantiser, or of nothing
};

// Joined with another range it is that one.
inline constexpr Range no_range{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};

struct FitChannelReport : LayerCounts {
  Range source_range;        // finite source values, absolute; 0..0 when there are none
  bool any_finite = false;   // there are some
  std::vector<Range> frames; // the same for each frame; empty when layers were given
  uint64_t source_samples = 0;
  uint64_t cc_relevant = 0;               // source samples further than the threshold from air
  uint64_t nonfinite = 0;                 // source values
  std::vector<uint64_t> clamped_slabs;    // of the sites clamped, those of each slab that was counted
  LayerCounts lasting;                    // of the first FitOptions::lasting_layers among those counted
  double coding_max = 0, coding_rmse = 0; // stored values against those the filter made, over all sites
};

struct FitReport {
  Lattice4 lattice;
  std::vector<FitChannelReport> channels;
};

// A frame of a channel as the filters take it, and where it was missing; what it was given stays where it is.
struct PreparedFrame {
  Frame frame; // clamped, or filled in
  const FrameScan& scan;
  HoleMap holes;
  FaceLevels faces; // how samples beyond its faces are predicted, at all levels
};
// What a fit resamples: a prepared frame, or what it was halved to (halved_frame.h).
struct FrameImage {
  const Frame& frame;
  const CellRanges& cells;
  const FaceLevels& faces;
};

// The order of calls is the caller's (store/volume_writer.h): a fit takes frames or layers, no more of them
// than the series has, and nothing after finish or a failure.
class Fit {
 public:
  Fit(const FitOptions& options, FitSink sink, const Context& context, MaskSink masks = {});
  ~Fit();
  Fit(const Fit&) = delete;
  Fit& operator=(const Fit&) = delete;

  // Refuses what cannot be the next frame of a channel, for its boxes or its values, and changes nothing.
  [[nodiscard]] FrameScan check_frame(int channel, std::span<const FrameBox> boxes) const;
  // The next frame of a channel, for this fit and for those of the same series on other lattices; no boxes:
  // all air. Counts its samples and tells its mask. scan: what check_frame returned.
  [[nodiscard]] PreparedFrame prepare_frame(int channel, std::span<const FrameBox> boxes,
                                            const FrameScan& scan);
  // Takes it. Calls the sink when layers are complete. image: what is resampled; a low-pass takes the frame
  // itself.
  void add_frame(int channel, const PreparedFrame& frame, const FrameImage& image);
  void add_frame(int channel, std::span<const FrameBox> boxes) {
    const FrameScan scan = check_frame(channel, boxes);
    const PreparedFrame frame = prepare_frame(channel, boxes, scan);
    add_frame(channel, frame, {frame.frame, scan.cells, frame.faces});
  }
  // Refuses what cannot be the next layer of a channel, and changes nothing.
  [[nodiscard]] DirectLayerScan check_layer(int channel, std::span<const float> samples) const;
  // The next layer of a channel as samples (absolute values, x fastest, dims of lattice().space of the
  // layer's coset). Needs dims[3] > 0. scan: what check_layer returned.
  void add_layer(int channel, std::span<const float> samples, const DirectLayerScan& scan);
  void add_layer(int channel, std::span<const float> samples) {
    add_layer(channel, samples, check_layer(channel, samples));
  }
  // Returns whether a layer of any channel has been made.
  [[nodiscard]] bool has_begun() const;
  // The series has fewer frames than was said, and ends with the data that every channel got: with a layer
  // for the last frame, or where layers are given with the last one of these.
  void shorten(uint32_t frames);
  // Refuses to end where not every channel got the same number of frames, dims[3] of them when that was
  // given.
  void check_end() const;
  // No more data come.
  void end();
  // Emit what is left of a channel, and of all channels in turn.
  void finish_channel(int channel);
  // Returns what was counted, once all channels are finished.
  [[nodiscard]] FitReport report() const;
  // All of that.
  [[nodiscard]] FitReport finish();

  // Final when dims[3] > 0, or after finish; before, its spatial part is.
  [[nodiscard]] const Lattice4& lattice() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

} // namespace bccsplat
