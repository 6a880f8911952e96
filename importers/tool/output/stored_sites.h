// SPDX-License-Identifier: Apache-2.0
// Samples of a frame that a file holds as air: those that no stored site is near.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "readers/frame_reader.h"
#include "tool/handles.h"

namespace bcc4 {

// A field has small values beside what is stored, because its kernel goes through the samples. Where no site
// is stored within 1.5 distances of the lattice (on the source's grid: at the sample) the source was next to
// air, or sites there would have been kept; and what differs from air by less than the file can store is air,
// too. Exports write air there. Files that promise an error keep to the field, corrections and all, and so do
// those that go round in space.
class StoredSites {
 public:
  StoredSites() = default;
  StoredSites(const Device& device, const std::string& path, uint32_t channel);

  // Makes air of what is beyond the sites in some planes of the frame at an index, or of a region of it, from
  // `first_plane` on.
  void clear(double index, const SampleBox& region, uint64_t first_plane, std::span<float> values) const;

 private:
  std::optional<Volume> volume_; // by a kernel whose coefficients are the stored samples
  uint32_t channel_ = 0;
  float air_ = 0;
  float least_ = 0;  // difference from air
  double reach_ = 0; // samples
};

} // namespace bcc4
