// SPDX-License-Identifier: Apache-2.0
// A wish to stop that stays until it is taken back.
#pragma once

#include <atomic>
#include <cstdint>

namespace bccsplat {

// Any thread may use it at any time, a signal handler as well.
class CancelToken {
 public:
  void cancel() noexcept {
    uint64_t now = state_.load(std::memory_order_relaxed);
    while (!(now & set) && !state_.compare_exchange_weak(now, now + one_cancel + set)) {
    }
  }
  void reset() noexcept { state_.fetch_and(~set); }
  [[nodiscard]] bool cancelled() const noexcept { return state_.load(std::memory_order_relaxed) & set; }

  // Returns how often it was cancelled so far: a call that remembers it at its begin hears of a cancel that
  // has been reset since.
  [[nodiscard]] uint64_t cancels() const noexcept {
    return state_.load(std::memory_order_relaxed) / one_cancel;
  }
  [[nodiscard]] bool cancelled_since(uint64_t cancels_before) const noexcept {
    return cancelled() || cancels() != cancels_before;
  }

 private:
  static constexpr uint64_t set = 1, one_cancel = 2;
  static_assert(std::atomic<uint64_t>::is_always_lock_free);
  std::atomic<uint64_t> state_{0};
};

} // namespace bccsplat
