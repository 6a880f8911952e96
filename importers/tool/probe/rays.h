// SPDX-License-Identifier: Apache-2.0
// What `bcc4 probe --ray` looks for along lines of the world, and what is there.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/handles.h"
#include "tool/options.h"
#include "tool/view/transfer_function.h"

namespace bcc4 {

struct RayArguments {
  std::vector<std::array<double, 6>> rays; // from a place to a place
  std::optional<double> first, opacity;
  bool maximum = false;
  std::optional<uint32_t> samples;
  std::string tf; // a file

  // Whether a place is looked for along each ray, not the values along it.
  [[nodiscard]] bool picks() const { return first || opacity || maximum; }
};

void add_rays(const Command& command, RayArguments& arguments);
// What no single option can tell.
void check_rays(const RayArguments& arguments);

// A place on a ray.
struct RayPlace {
  size_t ray = 0; // from 0
  double distance = 0;
  std::array<double, 3> world{};
  double value = 0;                 // NaN: outside the data, or missing in it
  std::array<double, 3> gradient{}; // of what is looked for
};

class Rays {
 public:
  // What is given must outlive it. index: rays are between samples.
  Rays(const Volume& volume, uint32_t channel, const RayArguments& arguments, bool index);

  // Returns the values along all rays, or what is found along each, all NaN where nothing is, at a moment.
  [[nodiscard]] std::vector<RayPlace> at(double frame) const;

 private:
  struct Ray {
    std::array<double, 3> from{}, direction{}; // of length 1
    double length = 0;
  };
  [[nodiscard]] std::vector<RayPlace> values(double frame) const;
  [[nodiscard]] std::vector<RayPlace> found(double frame) const;

  const Volume& volume_;
  uint32_t channel_;
  const RayArguments& a_;
  std::optional<TransferFunction> function_; // none: the file's look
  std::vector<Ray> rays_;
  std::vector<uint32_t> samples_; // of each ray
  std::optional<SampleBox> box_;  // around all rays; none: all of the volume
  bool outside_ = false;          // all rays miss the volume
};

} // namespace bcc4
