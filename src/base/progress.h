// Progress of a long call and the wish to cancel it.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>

#include "base/error.h"

namespace bccsplat {

// Hands a fraction in [0, 1] that never falls to a callback, at most 30 times a second; a non-zero answer
// cancels. Any thread may call it. Stages divide their share by `Span`s of [0, 1].
class Progress {
 public:
  using Callback = std::function<int(double fraction)>;
  Progress() = default;
  explicit Progress(Callback callback) : callback_(std::move(callback)) {}

  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }

  // Throws Code::cancelled once cancelled. Cheap: one load.
  void check() const {
    if (cancelled()) fail(Code::cancelled, "cancelled by the caller");
  }

  void report(double fraction) {
    if (callback_) {
      const std::unique_lock lock(mutex_, std::try_to_lock);
      const auto now = std::chrono::steady_clock::now();
      if (lock && fraction >= reported_ && (fraction >= 1 || now - last_ >= std::chrono::milliseconds(34))) {
        reported_ = fraction;
        last_ = now;
        if (callback_(fraction) != 0) cancel();
      }
    }
    check();
  }

 private:
  Callback callback_;
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;
  double reported_ = 0;
  std::chrono::steady_clock::time_point last_{};
};

} // namespace bccsplat
