// Progress of a long call and the wish to cancel it.
#pragma once

#include <algorithm>
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

  // Throws Code::cancelled once cancelled. Stages that cannot tell how far they are give the host its chance
  // to cancel here: the callback hears the last fraction again when it is due. Cheap: a load and, with a
  // callback, a look at the clock.
  void check() {
    if (callback_ && since_last() >= interval) ask(-1);
    throw_if_cancelled();
  }

  void report(double fraction) {
    if (callback_) ask(fraction);
    throw_if_cancelled();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::duration interval = std::chrono::milliseconds(34);

  [[nodiscard]] Clock::duration since_last() const {
    return Clock::now().time_since_epoch() - last_.load(std::memory_order_relaxed);
  }
  // A negative fraction is the last one.
  void ask(double fraction) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return;
    reached_ = std::max(reached_, fraction); // also between calls, so that a check does not take a report's turn
    const bool due = !asked_ || fraction >= 1 || since_last() >= interval;
    if (!due) return;
    asked_ = true;
    fraction = reached_;
    last_.store(Clock::now().time_since_epoch(), std::memory_order_relaxed);
    if (callback_(fraction) != 0) cancel();
  }
  void throw_if_cancelled() const {
    if (cancelled()) fail(Code::cancelled, "cancelled by the caller");
  }

  Callback callback_;
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;
  bool asked_ = false; // with reported_ under the mutex
  double reached_ = 0;
  std::atomic<Clock::duration> last_{Clock::now().time_since_epoch()};
};

} // namespace bccsplat
