// SPDX-License-Identifier: Apache-2.0
// The comparison with the source while a file is written: which frames take part, and what happens where it
// is not possible. It must be possible where a bound or all errors are asked for; else it is given up when
// memory is short or the kernel does not exist on the lattice. Coarser levels are compared, too, in some
// frames and at some samples; of a level whose comparison is given up nothing is told.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/error.h"
#include "store/round_trip.h"
#include "store/settings.h"

namespace bccsplat {

// Up to three of the frames first .. end - 1, evenly spread.
[[nodiscard]] std::vector<uint32_t> some_frames(uint32_t first, uint32_t end);

class Measuring {
 public:
  explicit Measuring(const WriterSettings& settings)
      : required_(settings.bounds_samples() || settings.psnr > 0 || settings.measure == Measure::all),
        wanted_(required_ || settings.measure == Measure::some) {}

  [[nodiscard]] bool required() const { return required_; }
  // Returns whether measuring is asked for and has neither begun nor been given up.
  [[nodiscard]] bool due() const { return wanted_ && !given_up_ && !round_trip_; }
  // Returns which of the frames first .. end - 1 are to be measured.
  [[nodiscard]] std::vector<uint32_t> choose_frames(uint32_t first, uint32_t end) const;
  // The same for coarser levels.
  [[nodiscard]] std::vector<uint32_t> choose_level_frames(uint32_t first, uint32_t end) const;

  // Runs a step of measuring; false where it has been given up, with this step at the latest.
  template<class Step> bool attempt(const Step& step) {
    if (given_up_) return false;
    try {
      step();
      return true;
    } catch (const Error& e) {
      if (required_ || (e.code() != Code::memory_budget && e.code() != Code::unsupported)) throw;
      round_trip_.reset();
      given_up_ = true;
      return false;
    }
  }
  // Hands the round trip, where there is one, to a step.
  template<class Step> void with_round_trip(const Step& step) {
    if (round_trip_) attempt([&] { step(*round_trip_); });
  }
  // The same at any level; level 0 is the one above.
  template<class Step> void with_level(int level, const Step& step) {
    if (level == 0) return with_round_trip(step);
    if (levels_.count(level) > 0) attempt_level(level, [&] { step(*levels_[level]); });
  }
  void begin(std::unique_ptr<RoundTrip> round_trip) { round_trip_ = std::move(round_trip); }
  template<class Make> void begin_level(int level, const Make& make) {
    attempt_level(level, [&] { levels_[level] = make(); });
  }
  // Null: nothing is measured.
  [[nodiscard]] RoundTrip* round_trip() const { return round_trip_.get(); }
  // Likewise of a coarser level.
  [[nodiscard]] const RoundTrip* level(int level) const {
    const auto at = levels_.find(level);
    return at == levels_.end() ? nullptr : at->second.get();
  }

 private:
  template<class Step> void attempt_level(int level, const Step& step) {
    try {
      step();
    } catch (const Error& e) {
      if (e.code() != Code::memory_budget && e.code() != Code::unsupported) throw;
      levels_.erase(level);
    }
  }

  bool required_, wanted_, given_up_ = false;
  std::unique_ptr<RoundTrip> round_trip_;
  std::map<int, std::unique_ptr<RoundTrip>> levels_; // 1 ..
};

} // namespace bccsplat
