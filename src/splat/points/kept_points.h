// SPDX-License-Identifier: Apache-2.0
// The points of a slice, made when a picture first needs them and kept with the slice.
#pragma once

#include <memory>
#include <mutex>
#include <utility>

#include "splat/points/points.h"

namespace bccsplat {

class KeptPoints {
 public:
  KeptPoints() = default;
  // Points that are there already.
  explicit KeptPoints(SplatPoints made) : points_(std::make_unique<const SplatPoints>(std::move(made))) {}
  // The same slice at every call; any thread may call. Throws memory_budget, cancelled.
  [[nodiscard]] const SplatPoints& of(const Slice& slice, const Context& context) const {
    const std::scoped_lock lock(mutex_);
    if (!points_) points_ = std::make_unique<const SplatPoints>(make_points(slice, context));
    return *points_;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::unique_ptr<const SplatPoints> points_;
};

} // namespace bccsplat
