// SPDX-License-Identifier: Apache-2.0
// A moment of a series by what it is merged of: layers of coefficients with their weights. Who merges them
// elsewhere, as a GPU does, knows layers again by it; the bricks are made here when somebody asks for them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "base/context.h"
#include "field/coefficients/coefficient_layer.h"

namespace bccsplat {

using MergedCosets = std::array<BrickLayer, 2>; // of a CC lattice the first alone

// Immutable. Any thread may ask.
class MomentPlan {
 public:
  struct Part {
    int32_t layer = 0; // inside the series
    int coset = 0;
    float weight = 0;             // not negative
    std::array<float, 2> range{}; // of the layer's coefficients, and 0
    CoefficientLayer of;
  };
  using Merge = std::function<MergedCosets(const std::vector<Part>&, const Context&)>;

  // series: what its layers are of, by a number that no other coefficients have (Coefficients::number()). No
  // part has holes; each layer is in one part.
  MomentPlan(uint64_t series, std::vector<Part> parts, Merge merge)
      : series_(series), parts_(std::move(parts)), merge_(std::move(merge)) {}

  [[nodiscard]] uint64_t series() const { return series_; }
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  // Bounds of the coefficients at whatever weights: those of all moments between the same layers.
  [[nodiscard]] std::array<float, 2> range() const;
  // The most that the weights of a coset's layers add up to, rounded up so that it is the same for moments
  // between the same layers; 1 but for kernels whose sum ripples, and sums over time.
  [[nodiscard]] float largest_weight() const;
  [[nodiscard]] int64_t kept_sites() const;

  // Merges at the first call. Throws memory_budget, cancelled. Without a context in this thread alone.
  [[nodiscard]] const MergedCosets& merged(const Context& context) const;
  [[nodiscard]] const MergedCosets& merged() const;
  [[nodiscard]] bool is_merged() const { return there_.load(std::memory_order_acquire); }
  // Memory of the merged bricks, or before they are merged the most that they may take.
  [[nodiscard]] uint64_t bytes() const;

 private:
  uint64_t series_;
  std::vector<Part> parts_;
  Merge merge_;
  mutable std::mutex mutex_;
  mutable std::atomic<bool> there_{false};
  mutable MergedCosets cosets_;
};

// The bricks of a slice, coset by coset: there, or merged of a moment when they are first looked at.
class SliceCosets {
 public:
  SliceCosets() = default;
  explicit SliceCosets(std::shared_ptr<const MomentPlan> moment) : moment_(std::move(moment)) {}

  const BrickLayer& operator[](size_t coset) const { return all()[coset]; }
  BrickLayer& operator[](size_t coset) { return all()[coset]; }
  [[nodiscard]] auto begin() const { return all().begin(); }
  [[nodiscard]] auto end() const { return all().end(); }
  [[nodiscard]] auto begin() { return all().begin(); }
  [[nodiscard]] auto end() { return all().end(); }

  // What they are merged of; null: they are no moment of a series, or somebody has changed them.
  [[nodiscard]] const MomentPlan* moment() const { return moment_.get(); }
  // Merges them by several threads, if they are not there.
  void make(const Context& context) const {
    if (moment_) (void)moment_->merged(context);
  }
  [[nodiscard]] int64_t kept_sites() const;
  [[nodiscard]] uint64_t bytes() const;

 private:
  [[nodiscard]] const MergedCosets& all() const { return moment_ ? moment_->merged() : own_; }
  [[nodiscard]] MergedCosets& all() {
    if (moment_) own_ = moment_->merged(), moment_ = nullptr;
    return own_;
  }

  MergedCosets own_;
  std::shared_ptr<const MomentPlan> moment_;
};

} // namespace bccsplat
