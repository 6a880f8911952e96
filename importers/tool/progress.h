// SPDX-License-Identifier: Apache-2.0
// One line of progress on stderr: redrawn on a terminal, a new line every 10 s elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace bcc4 {

class Progress {
 public:
  // Amounts are bytes when `in_bytes`, else steps named `unit`. `quiet` shows nothing.
  Progress(std::string label, uint64_t total, bool in_bytes, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(uint64_t done, const std::string& detail);
  // Takes the line away.
  void clear();
  [[nodiscard]] double seconds() const;

  // A bccsplat_progress_fn that shows the fraction; user: a Progress of `fraction_steps` steps.
  static int32_t show_fraction(void* user, double fraction);
  static constexpr uint64_t fraction_steps = 1000;

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  uint64_t total_;
  bool in_bytes_, quiet_, terminal_;
  Clock::time_point start_ = Clock::now(), shown_ = start_;
  size_t width_ = 0; // of the line on the screen
};

} // namespace bcc4
