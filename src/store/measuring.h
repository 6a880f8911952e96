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
      : required_(settings.must_measure()), wanted_(required_ || settings.measure == Measure::some) {}

  [[nodiscard]] bool required() const { return required_; }
  // Returns whether measuring is asked for and has neither begun nor been given up.
  [[nodiscard]] bool due() const { return wanted_ && !given_up_ && !round_trip(); }
  // Returns which of the frames first .. end - 1 are to be measured.
  [[nodiscard]] std::vector<uint32_t> choose_frames(uint32_t first, uint32_t end) const;
  // The same for coarser levels.
  [[nodiscard]] std::vector<uint32_t> choose_level_frames(uint32_t first, uint32_t end) const;

  // Runs a step of measuring a level; false where that has been given up, with this step at the latest.
  template<class Step> bool attempt(const Step& step, int level = 0) {
    if (level == 0 && given_up_) return false;
    try {
      step();
      return true;
    } catch (const Error& e) {
      if (e.code() != Code::memory_budget && e.code() != Code::unsupported) throw;
      if (level == 0 && required_) throw;
      given_up_ = given_up_ || level == 0;
      levels_.erase(level);
      return false;
    }
  }
  // Hands the round trip of a level, where there is one, to a step.
  template<class Step> void with_level(int level, const Step& step) {
    if (const auto at = levels_.find(level); at != levels_.end()) attempt([&] { step(*at->second); }, level);
  }
  template<class Make> void begin(int level, const Make& make) {
    attempt([&] { levels_[level] = make(); }, level);
  }
  // Null: nothing is measured of that level.
  [[nodiscard]] const RoundTrip* round_trip(int level = 0) const {
    const auto at = levels_.find(level);
    return at == levels_.end() ? nullptr : at->second.get();
  }

 private:
  bool required_, wanted_, given_up_ = false;
  std::map<int, std::unique_ptr<RoundTrip>> levels_;
};

} // namespace bccsplat
