// SPDX-License-Identifier: Apache-2.0
// What of a frame a file holds as air: samples that no stored site is near.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "readers/frame_reader.h"
#include "tool/handles.h"

namespace bcc4 {

// A field has small values beside what is stored, because its kernel goes through the samples. Where no site
// is stored within two samples or three the source was air, and so is what differs from air by less than the
// file can store: exports write air there. Files that promise an error keep to the field, corrections and
// all, and so do those whose sites are all stored.
class StoredSites {
 public:
  StoredSites() = default;
  StoredSites(const Device& device, const std::string& path, uint32_t channel);

  // The sites near a moment; to be asked with frames of the same moment.
  void move_to(double index, const std::optional<SampleBox>& region);
  // Makes air of what is beyond the sites in some planes of the frame or region, from `first_plane` on.
  void clear(uint64_t first_plane, const std::array<uint64_t, 3>& dims, std::span<float> values) const;

 private:
  std::optional<Volume> volume_; // by a kernel whose field is air where it reaches no site
  std::optional<Slice> slice_;
  uint32_t channel_ = 0;
  float air_ = 0;
  float least_ = 0; // difference from air
};

} // namespace bcc4
