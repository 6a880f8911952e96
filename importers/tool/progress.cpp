// SPDX-License-Identifier: Apache-2.0
#include "tool/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "readers/text.h"
#include "tool/system.h"

namespace bcc4 {
namespace {

std::string clock_text(double seconds) {
  const int64_t s = std::llround(std::min(seconds, 3.6e6));
  const auto two = [](int64_t n) { return concat(n < 10 ? "0" : "", n); };
  return s >= 3600 ? concat(s / 3600, ":", two(s / 60 % 60), ":", two(s % 60))
                   : concat(s / 60, ":", two(s % 60));
}

} // namespace

Progress::Progress(std::string label, uint64_t total, bool in_bytes, bool quiet)
    : label_(std::move(label)), total_(total), in_bytes_(in_bytes), quiet_(quiet),
      terminal_(stderr_is_terminal()) {}

Progress::~Progress() { clear(); }

double Progress::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void Progress::update(uint64_t done, const std::string& detail) {
  const auto now = Clock::now();
  if (quiet_ || now - shown_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(10)))
    return;
  shown_ = now;
  const double elapsed = seconds(),
               fraction = total_ > 0 ? static_cast<double>(done) / static_cast<double>(total_) : 0;
  std::string line = concat(label_, detail.empty() ? "" : "  ", detail);
  if (total_ > 0) line += concat("  ", static_cast<int>(100 * fraction), " %");
  if (in_bytes_ && elapsed > 0)
    line += concat("  ", short_number(static_cast<double>(done) / elapsed / 1e6, 3), " MB/s");
  if (fraction > 0) line += concat("  ETA ", clock_text(elapsed * (1 - fraction) / fraction));
  if (terminal_) {
    const std::string blank(line.size() < width_ ? width_ - line.size() : 0, ' ');
    std::fprintf(stderr, "\r%s%s", line.c_str(), blank.c_str());
    std::fflush(stderr);
    width_ = line.size();
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
}

void Progress::clear() {
  if (width_ > 0) {
    std::fprintf(stderr, "\r%s\r", std::string(width_, ' ').c_str());
    std::fflush(stderr);
  }
  width_ = 0;
}

int32_t Progress::show_fraction(void* user, double fraction) {
  static_cast<Progress*>(user)->update(static_cast<uint64_t>(fraction_steps * fraction), "");
  return 0;
}

} // namespace bcc4
