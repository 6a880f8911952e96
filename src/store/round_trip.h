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
#include "fit/layer_window.h"
#include "formats/bcc4/coding/residuals.h"
#include "points/slab_layers.h"
#include "points/values.h"
#include "store/held_frame.h"

namespace bccsplat {

// Differences over one set of samples.
struct ErrorSum {
  double largest = 0, squares = 0;
  uint64_t count = 0;
  void add(double difference);
  void add(const ErrorSum& other);
  [[nodiscard]] double rms() const;
  // dB; infinite without any difference, NaN without samples.
  [[nodiscard]] double psnr(double peak) const;
};

// Of finite source samples, corrections included.
struct SampleErrors {
  ErrorSum all, non_air;  // non_air: source samples further than the threshold from air
  ErrorSum bare;          // all, before corrections; without those that lie in holes
  uint64_t lost = 0;      // samples that lie in holes of the lattice and got no correction
  uint64_t corrected = 0; // samples with a correction
  uint64_t frame = 0;     // of the largest difference, as are the next three
  std::array<uint64_t, 3> voxel{};
  double expected = 0, got = 0;
  void add(const SampleErrors& other);
};

// Throws bound_not_met unless the errors of a channel, its range the peak, reach `psnr` dB.
void require_psnr(const std::string& channel, const SampleErrors& errors, const Range& range, double psnr);

struct RoundTripChannel {
  std::string name; // for error texts
  float air = 0, threshold = 0;
  double bound = 0;       // 0: measured only
  bool whole = true;      // it is given all layers of the series
  double sample_step = 0; // of what is stored, as readers know it (formats/bcc4/sample_step.h)
};

// Corrections of a frame.
using ResidualSink = std::function<void(int channel, uint32_t frame, const FrameResiduals& residuals)>;

// Layers begin .. end - 1.
struct LayerSpan {
  int32_t begin = 0, end = 0;
};
// Stored layers that the error of a frame depends on. coefficients: they hold those of the kernel.
[[nodiscard]] LayerSpan layers_to_measure(const Lattice4& lattice, const std::string& kernel,
                                          bool coefficients, uint32_t frame);

class RoundTrip {
 public:
  // kernel: the one the error is measured with; coefficients: layers hold coefficients of it. frames: those
  // that are measured, rising. first_layer: the first that is given, layers_to_measure before the first
  // frame. every: of the source samples, those whose indices it divides are compared; all of them where there
  // is a bound.
  RoundTrip(const Lattice4& lattice, const std::vector<RoundTripChannel>& channels, std::string kernel,
            bool coefficients, std::vector<uint32_t> frames, ResidualSink sink, const Context& context,
            int32_t first_layer = 0, int32_t every = 1);
  ~RoundTrip();

  // Every frame of a channel, before the fit gets it.
  void add_frame(int channel, uint32_t frame, std::span<const FrameBox> boxes);
  // The next layers of a channel, `first` and up, as stored. Frames whose layers are all there are measured
  // at once. Throws bound_not_met where even corrections cannot keep the bound.
  void add_layers(int channel, int32_t first, const SlabLayers& layers);

  // The series ends sooner than was said; frames behind its end are not measured.
  void set_lattice(const Lattice4& lattice);

  // Value of one step of the corrections.
  [[nodiscard]] static double step(double bound) { return bound; }
  [[nodiscard]] const std::vector<uint32_t>& frames() const { return frames_; }
  // Of the field that the corrections of a channel are differences from; none: air, or no bound.
  [[nodiscard]] std::optional<float> base(int channel) const;
  // Of the series, and of frames()[i] once measured.
  [[nodiscard]] const SampleErrors& errors(int channel) const;
  [[nodiscard]] const SampleErrors& frame_errors(int channel, size_t i) const;

 private:
  struct Channel;
  void begin_turn(Channel& c, int32_t first) const;
  [[nodiscard]] LayerSpan needed_for(const Channel& c, size_t at) const;
  void measure(Channel& c, int index, size_t at);
  [[nodiscard]] SampleErrors compare(const Channel& c, const Coefficients& field, uint32_t frame,
                                     FrameResiduals& residuals) const;

  Lattice4 lattice_;
  std::string kernel_;
  std::vector<uint32_t> frames_;
  ResidualSink sink_;
  Context context_;
  int64_t every_;
  std::vector<std::unique_ptr<Channel>> channels_;
};

} // namespace bccsplat
