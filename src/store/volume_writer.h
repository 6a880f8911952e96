// SPDX-License-Identifier: Apache-2.0
// A volume in, a file out: the pipeline of a writer, which owns the order of its calls.
//
//   WriterOpening   what is made, from which options: a file, a part, or what continues a file
//   WriterInput     frames, or layers, or a field
//     -> LevelFits     at each level slabs of lattice samples
//     -> WriterOutput  the file, with a journal, as a part, or behind the slabs of an older one
//     -> Measuring     what a reader will get, against the frames; corrections back into the file
//   WriterEnding    what is said about the series when it ends
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "store/writer_ending.h"
#include "store/writer_input.h"

namespace bccsplat {

// Where the sites of a layer are: origin + step * (i, j, k) in index space, at a frame index.
struct LayerGeometry {
  int coset = 0;
  FieldGrid sites;
  int64_t layers = 0; // of the series
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
  [[nodiscard]] const std::vector<std::string>& warnings() const { return ending_.warnings(); }

 private:
  enum class State : uint8_t { open, failed, finished };

  void require_open() const;
  void require_open(uint32_t channel) const;
  // Checks what may be refused, without harm; what fails otherwise leaves the writer failed.
  template<class Check> auto check(const Check& step);
  // A step that fails leaves the writer failed.
  template<class Step> void run_step(const Step& step);
  void take_text(uint64_t bytes, uint64_t replaced);

  Context context_;
  Measuring measuring_;
  WriterOpening opening_;
  LevelFits fits_;
  WriterOutput output_;
  WriterInput input_;
  WriterEnding ending_;
  State state_ = State::open;
  uint64_t text_bytes_ = 0; // of attributes and sources
};

} // namespace bccsplat
