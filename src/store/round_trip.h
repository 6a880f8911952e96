// SPDX-License-Identifier: Apache-2.0
// What becomes of the source samples: layers as they are stored -> the field as a reader reconstructs it ->
// the difference from the source, frame by frame while the file is written; and the corrections that keep it
// within a bound.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "formats/bcc4/coding/residuals.h"
#include "points/slab_layers.h"
#include "points/values.h"
#include "store/layer_window.h"
#include "store/sample_comparison.h"
#include "store/sample_errors.h"

namespace bccsplat {

// Corrections of a frame.
using ResidualSink = std::function<void(int channel, uint32_t frame, const FrameResiduals& residuals)>;

// Layers begin .. end - 1.
struct LayerSpan {
  int32_t begin = 0, end = 0;
};
// Stored layers that the error of a frame depends on.
[[nodiscard]] LayerSpan layers_to_measure(const Lattice4& lattice, const std::string& kernel, uint32_t frame);

// What is compared of the source.
struct RoundTripScope {
  int32_t first_layer = 0; // that is given: layers_to_measure before the first frame
  int32_t every = 1;       // of the samples, those whose indices it divides; 1 where there is a bound
  bool in_boxes = false;   // of large frames boxes (measured_boxes.h); false where there is a bound
  bool at_sites = false;   // where the field goes through the samples, these are compared (site_planes.h)
  // The samples of a block of space, and the bricks that the field at these is a sum of. By default all.
  Region samples{};
  BrickBox bricks{};
};

class MeasuredField;

class RoundTrip {
 public:
  // kernel: the one the error is measured with. frames: those that are measured, rising.
  RoundTrip(const Lattice4& lattice, const std::vector<RoundTripChannel>& channels, std::string kernel,
            std::vector<uint32_t> frames, ResidualSink sink, const Context& context,
            const RoundTripScope& scope = {});
  ~RoundTrip();

  // Every frame of a channel, before the fit gets it.
  void add_frame(int channel, uint32_t frame, std::span<const FrameBox> boxes);
  // The next layers of a channel, `first` and up, as stored. Frames whose layers are all there are measured
  // at once. Throws bound_not_met where even corrections cannot keep the bound. given: the same layers before
  // they were coded with an error; read of channels that are as given.
  void add_layers(int channel, int32_t first, const SlabLayers& layers,
                  std::span<const SampleLayer> given = {});

  // The series ends sooner than was said; frames behind its end are not measured.
  void set_lattice(const Lattice4& lattice);
  // Measures the frames of a channel whose layers are there: of a series that ended sooner, those which
  // waited for layers that do not come.
  void measure_ready(int channel);

  // Value of one step of the corrections.
  [[nodiscard]] static double step(double bound) { return correction_step(bound); }
  [[nodiscard]] const std::vector<uint32_t>& frames() const { return frames_; }
  // Returns the base of the field that a channel's corrections are differences from; none: air, or no bound.
  [[nodiscard]] std::optional<float> base(int channel) const;
  // Return the errors of the series, and of frames()[i] once measured.
  [[nodiscard]] const SampleErrors& errors(int channel) const;
  [[nodiscard]] const SampleErrors& frame_errors(int channel, size_t i) const;

 private:
  struct Channel;
  void begin_turn(Channel& c, int32_t first) const;
  void choose_base_when_due(Channel& c) const;
  [[nodiscard]] LayerSpan needed_for(const Channel& c, size_t at) const;
  void measure(Channel& c, int index, size_t at);
  void note_layers(Channel& c, std::span<const SampleLayer> layers) const;
  [[nodiscard]] SampleErrors compare_at_sites(const Channel& c, uint32_t frame,
                                              FrameResiduals& residuals) const;
  [[nodiscard]] SampleErrors compare(const Channel& c, const MeasuredField& field, uint32_t frame,
                                     FrameResiduals& residuals) const;

  Lattice4 lattice_;
  std::string kernel_;
  std::vector<uint32_t> frames_;
  ResidualSink sink_;
  Context context_;
  RoundTripScope scope_;
  std::vector<std::unique_ptr<Channel>> channels_;
};

} // namespace bccsplat
