// SPDX-License-Identifier: Apache-2.0
// Finds the slabs that a grown file shares with its earlier state.
#pragma once

#include <map>
#include <mutex>
#include <utility>

#include "formats/bcc4/read/reader.h"

namespace bccsplat {

// Both readers outlive it. Any thread may ask.
class UnchangedSlabs {
 public:
  UnchangedSlabs(const Bcc4Reader& older, const Bcc4Reader& newer);

  // Returns whether the chunks of a slab are the same bytes with the same meaning. Reads the index of both
  // files, as far as it is not cached.
  [[nodiscard]] bool slab(const ChannelLevel& at, int32_t slab) const;
  [[nodiscard]] bool layer(const ChannelLevel& at, int32_t layer) const;

 private:
  [[nodiscard]] bool compare(const ChannelLevel& at, int32_t slab) const;

  const Bcc4Reader& older_;
  const Bcc4Reader& newer_;
  bool comparable_;
  mutable std::mutex mutex_;
  mutable std::map<std::pair<ChannelLevel, int32_t>, bool> known_;
};

} // namespace bccsplat
