// SPDX-License-Identifier: Apache-2.0
// Progress of a long call and the wish to cancel it.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>

#include "base/cancel_token.h"
#include "base/error.h"

namespace bccsplat {

// Hands a fraction in [0, 1] that never falls to a callback, at most 30 times a second; a non-zero answer
// cancels. Any thread may call it.
//
// Stages that may be part of something longer tell how far they are by advance(), which counts only where the
// call asked for it; a caller gives each of its stages a share of [0, 1]: a Progress of its own.
class Progress {
 public:
  using Callback = std::function<int(double fraction)>;
  Progress() = default;
  // With count_stages advance() reports; else it only checks for a cancel.
  explicit Progress(Callback callback, bool count_stages = false)
      : callback_(std::move(callback)), counts_(count_stages) {}
  // The part from begin to end of another Progress, which must outlive it: a stage's [0, 1] is mapped to it.
  Progress(Progress& whole, double begin, double end)
      : whole_(&whole), begin_(begin), length_(end - begin), counts_(whole.counts_) {}

  // What ends at a time, beside the progress of the call it works for, which outlives it and is not told how
  // far it is: it ends with Code::cancelled, too.
  Progress(const Progress& call, std::chrono::steady_clock::time_point end)
      : call_(&call), end_(end), timed_(true) {}

  // A token whose cancels from now on end the call as cancel() does, at most two; they outlive this. Null:
  // none.
  void watch(const CancelToken* token) {
    if (token) tokens_.at(watched_++) = {token, token->cancels()};
  }
  // Begins a call of an object that makes several with one Progress. Cancels of tokens before it count no
  // more; throws Code::cancelled where a token stands cancelled.
  void begin_call() {
    for (Watched& w : std::span(tokens_).first(watched_)) {
      w.cancels_before = w.token->cancels();
      if (w.token->cancelled()) fail_cancelled();
    }
  }

  void cancel() noexcept { whole_ ? whole_->cancel() : cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const noexcept {
    if (whole_) return whole_->cancelled();
    if (cancelled_.load(std::memory_order_relaxed) || (call_ && call_->cancelled())) return true;
    for (const Watched& w : std::span(tokens_).first(watched_))
      if (w.token->cancelled_since(w.cancels_before)) return true;
    return false;
  }
  // Throws Code::cancelled once cancelled; the host is not asked.
  void throw_if_cancelled() const {
    if (cancelled()) fail_cancelled();
  }

  // Throws Code::cancelled once cancelled. Stages that cannot tell how far they are give the host its chance
  // to cancel here: the callback hears the last fraction again when it is due. It is cheap: a load and, with
  // a callback, a look at the clock.
  void check() {
    if (whole_) return whole_->check();
    if (callback_ && since_last() >= interval) ask(-1);
    if (timed_ && Clock::now() >= end_) cancel();
    throw_if_cancelled();
  }

  void report(double fraction) {
    if (whole_) return whole_->report(begin_ + length_ * fraction);
    if (callback_) ask(fraction);
    if (timed_ && Clock::now() >= end_) cancel();
    throw_if_cancelled();
  }

  // Says that a stage has done so many parts of a total.
  void advance(uint64_t done, uint64_t total) {
    if (!counts_) return check();
    report(static_cast<double>(done) / static_cast<double>(total));
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::duration interval = std::chrono::milliseconds(34);

  [[nodiscard]] Clock::duration since_last() const {
    return Clock::now().time_since_epoch() - last_.load(std::memory_order_relaxed);
  }
  // A negative fraction means the last one.
  void ask(double fraction) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return;
    // It is kept between calls, too, so that a check does not take a report's turn.
    reached_ = std::max(reached_, fraction);
    const bool due = !asked_ || fraction >= 1 || since_last() >= interval;
    if (!due) return;
    asked_ = true;
    fraction = reached_;
    last_.store(Clock::now().time_since_epoch(), std::memory_order_relaxed);
    if (callback_(fraction) != 0) cancel();
  }
  [[noreturn]] static void fail_cancelled() { fail(Code::cancelled, "cancelled by the caller"); }

  struct Watched {
    const CancelToken* token = nullptr;
    uint64_t cancels_before = 0;
  };

  Callback callback_;
  std::array<Watched, 2> tokens_{};
  size_t watched_ = 0;
  const Progress* call_ = nullptr;
  std::chrono::steady_clock::time_point end_{};
  bool timed_ = false;
  Progress* whole_ = nullptr; // null: the call's own
  double begin_ = 0, length_ = 1;
  bool counts_ = false;
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;
  bool asked_ = false; // under the mutex, as reached_ is
  double reached_ = 0;
  std::atomic<Clock::duration> last_{Clock::now().time_since_epoch()};
};

} // namespace bccsplat
