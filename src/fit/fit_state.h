// SPDX-License-Identifier: Apache-2.0
// What a fit holds, and its steps: frames in (fit_frames.cpp), layers out of them (fit_layers.cpp; of
// periodic series fit_turns.cpp), finished slabs to the sink (fit_slabs.cpp).
#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fit/beyond/end_layers.h"
#include "fit/direct_layer.h"
#include "fit/fit.h"
#include "fit/kept/layer.h"
#include "fit/kept/site_block.h"
#include "fit/resample/holes.h"
#include "fit/resample/lowpass.h"
#include "fit/resample/resample.h"

namespace bccsplat {

// Returns how much the filter in time is stretched.
[[nodiscard]] double time_widening(const Lattice4& lattice);

struct Fit::State {
  struct Channel;

  State(const FitOptions& o, FitSink s, const Context& c, MaskSink m);

  FitOptions options;
  FitSink sink;
  MaskSink mask_sink;
  Context context;
  SiteBlockPool pool; // outlives the channels
  Lattice4 lattice;   // of two frames as long as their number is not known
  FitScope scope;
  std::map<FaceLevels, SpatialResampler> resamplers; // made when a frame needs them
  EndPredictions ends;
  std::vector<std::unique_ptr<Channel>> channels;
  bool layers_given = false; // instead of frames
  // Where a periodic series begins: the window's first frame (a low-pass holds those before it back until the
  // end), the layer that can be made first, and the number of frames that are needed again at the end.
  struct Turn {
    uint32_t first_frame = 0;
    int32_t first_layer = 0;
    uint32_t head_frames = 0;
  } turn;
  bool finished = false;

  [[nodiscard]] Channel& channel(int index) const;
  [[nodiscard]] bool length_known() const { return options.dims[3] > 0 || finished; }

  // Frames in.
  [[nodiscard]] FrameScan check_frame(int index, std::span<const FrameBox> boxes) const;
  [[nodiscard]] PreparedFrame prepare_frame(int index, std::span<const FrameBox> boxes,
                                            const FrameScan& scan);
  void add_frame(int index, const PreparedFrame& given, const FrameImage& image);
  // Takes the frames that a low-pass holds back.
  void finish_lowpass(Channel& c);

  // Layers in, from the first one on.
  [[nodiscard]] DirectLayerScan check_layer(int index, std::span<const float> samples) const;
  void add_layer(int index, std::span<const float> samples, const DirectLayerScan& scan);

  // Layers out: those whose frames are all there.
  void make_layers(Channel& c);
  // Makes one, counts it, and hands out the slab that it completes.
  void emit(Channel& c, int32_t layer, std::span<const LayerTap> taps, size_t nearest);
  void hand_out(Channel& c);
  // Finds where a periodic series begins, for all channels, then has one begin there.
  void begin_turn();
  void begin_turn(Channel& c) const;
  // The layer behind the last one.
  [[nodiscard]] int32_t end_layer() const {
    return options.part ? options.part->end_layer : turn.first_layer + lattice.layers();
  }

  void shorten(uint32_t frames);
  void check_end() const;
  void end();
  void finish_channel(int index);
  [[nodiscard]] FitReport report() const;

 private:
  void begin_part(Channel& c, const FitPart& part) const;
  // The frames of the series as far as they were given.
  [[nodiscard]] uint32_t frames_given() const;

  [[nodiscard]] bool counts_frame(uint32_t frame) const {
    return !options.part || options.part->counted.has_frame(frame);
  }
  [[nodiscard]] bool is_block() const { return options.part && !options.part->counted.all_space(); }
  // Returns the bricks of layers that are made and counted.
  [[nodiscard]] LayerBricks layer_bricks() const {
    return options.part ? options.part->bricks : LayerBricks{};
  }
  [[nodiscard]] uint64_t counted_sites(int coset) const;
  [[nodiscard]] bool counts_layer(int32_t layer) const {
    return !options.part || (layer >= options.part->first_own && layer < options.part->end_own);
  }
  [[nodiscard]] std::array<int64_t, 3> source_dims() const {
    return {options.dims[0], options.dims[1], options.dims[2]};
  }
  [[nodiscard]] Frame frame_of(const Channel& c, std::span<const FrameBox> boxes) const;
  // Returns whether a frame is not missing altogether: what is not finite may be clamped, and a block does
  // not know of the rest.
  [[nodiscard]] bool is_known(const FrameScan& scan) const {
    return scan.finite > 0 || options.fill.bounded() ||
           (scan.nonfinite > 0 && options.nonfinite == NonFinite::clamp);
  }
  // Returns what an infinity of a channel becomes, relative to air.
  [[nodiscard]] std::array<float, 2> clamp_range(const Channel& c) const;
  // Counts a frame of a part's own, or of any series that is not divided.
  void count_frame(Channel& c, const FrameScan& scan) const;
  [[nodiscard]] FaceLevels faces_of(const Frame& frame) const;
  [[nodiscard]] Lowpass::Sink filtered(Channel& c);
  // Takes a frame as resampled to the lattice. known: it is not missing altogether.
  void take_frame(Channel& c, const FrameImage& image, bool known, const HoleMap& holes);
  [[nodiscard]] const SpatialResampler& resampler_of(const FrameImage& image);

  void make_still_layers(Channel& c);
  void make_moving_layers(Channel& c, int64_t frames, bool complete);
  void make_turning_layers(Channel& c, bool complete);
  // Returns whether missing frames at the start wait for what they are to hold, as long as it can matter.
  [[nodiscard]] bool waits_for_data(const Channel& c) const;
  // Returns the taps of a layer; frames beyond the ends of a series of n are replaced by those that predict
  // them.
  [[nodiscard]] std::vector<std::pair<int64_t, float>> weighted_frames(Channel& c, const FilterTable& table,
                                                                       int64_t n);
  // Frames that are missing altogether become what lies between those that are there, on either side, where
  // the list reaches so far: the next one gets a part of their weight.
  template<class FrameOf>
  static void weigh_gaps(std::vector<std::pair<int64_t, float>>& list, const FrameOf& frame_of) {
    const size_t count = list.size();
    int64_t last = INT64_MIN;
    for (const auto& [f, weight] : list) last = std::max(last, f);
    for (size_t i = 0; i < count; ++i) {
      const auto [f, weight] = list[i];
      const int64_t behind = frame_of(f).gap;
      if (behind == 0) continue;
      int64_t next = f + 1;
      while (next <= last && frame_of(next).gap > 0) ++next;
      if (next > last) continue;
      const float share = static_cast<float>(behind) / static_cast<float>(behind + next - f);
      list[i].second = weight * (1 - share);
      const auto found =
          std::find_if(list.begin(), list.end(), [&](const auto& p) { return p.first == next; });
      if (found != list.end())
        found->second += weight * share;
      else
        list.emplace_back(next, weight * share);
    }
  }
  // Returns whether each layer is a frame, so that none depends on other frames.
  [[nodiscard]] bool layers_are_frames() const {
    return length_known() && !options.periodic && options.lead == 0 && lattice.time_step == 1 &&
           time_widening(lattice) == 1;
  }
  // Returns how bold predictions at an end of a series of n frames are, settled by the frames they look at.
  [[nodiscard]] uint8_t end_level(Channel& c, bool last, int64_t n) const;
  // Forgets frames that no further layer needs when so many have come: neither directly nor to predict those
  // beyond the last one.
  void forget_frames(Channel& c, int64_t frames) const;
  // Forgets frames whose layer is made, where each layer is a frame; `kept` of them stay.
  static void forget_made(Channel& c, size_t kept);
  // Returns a frame by its number in a periodic series, as counted from turn.first_frame on.
  [[nodiscard]] const FrameSites& frame_at(const Channel& c, int64_t f) const;
  // Returns the number, from turn.first_frame on, of a frame of any turn.
  [[nodiscard]] int64_t counted_frame(int64_t frame) const {
    return turn.first_frame + lattice.turned_frame(frame - turn.first_frame);
  }
  // Moves frames that no further layer of the first turn needs to the head, if the second turn does.
  void turn_frames(Channel& c) const;
};

// One channel on its way through.
struct Fit::State::Channel {
  Channel(int number, const FitChannel& o)
      : index(number), options(o), maker(o.quantiser, o.threshold, o.ringing), lasting(maker.again()),
        uncounted(maker.again()) {}

  int index;
  FitChannel options;
  // lasting: of the first layers; uncounted: of those beyond a part's own.
  LayerMaker maker, lasting, uncounted;
  FitChannelReport report;
  bool any_known = false; // a frame that is not missing altogether

  std::unique_ptr<Lowpass> lowpass; // null: none
  bool filtered = false;            // it has handed out all frames
  uint32_t given = 0;               // frames
  uint32_t frames = 0;              // those of them in the window or past it: a low-pass holds some back
  int32_t next_layer = 0;           // the first not made; of a periodic series counted on in the second turn
  std::deque<FrameSites> window;    // frames window_first ..
  uint32_t window_first = 0;
  std::vector<FrameSites> head; // of a periodic series: frames turn.first_frame .. that its end needs again
  EndLevels end_levels;

  std::vector<SampleLayer> slab; // layers made and not handed out
  std::vector<Reservation> slab_memory;
  double slab_rounded = 0; // SlabLayers::rounded
  int32_t slab_index = 0;

  // Returns a frame of the window by its number.
  [[nodiscard]] const FrameSites& frame(int64_t f) const { return window[f - window_first]; }
  void forget_first() {
    window.pop_front();
    ++window_first;
  }
  // Refuses values so far from air that filters overflow.
  void check_range(double low, double high, const std::string& what) const;
  void note_range(double low, double high);
};

} // namespace bccsplat
