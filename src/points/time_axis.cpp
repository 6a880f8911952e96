// SPDX-License-Identifier: Apache-2.0
#include "points/time_axis.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace bccsplat {

TimeAxis::TimeAxis(std::vector<double> times)
    : count_(static_cast<double>(times.size())), times_(std::move(times)) {
  const size_t n = times_.size();
  if (n == 0) fail(Code::invalid_argument, "times: there are no frames");
  for (size_t i = 1; i < n; ++i)
    if (!(times_[i] > times_[i - 1]))
      fail(Code::invalid_argument, "times: time ", times_[i], " of frame ", i, " does not rise above ",
           times_[i - 1]);
  slopes_.assign(n, 0);
  if (n < 2) return;
  const auto step = [&](size_t i) { return times_[i + 1] - times_[i]; };
  // The harmonic mean of the neighbouring steps keeps the curve monotone and is exact for equal steps.
  for (size_t i = 1; i + 1 < n; ++i) slopes_[i] = 2 / (1 / step(i - 1) + 1 / step(i));
  // The slopes at the ends are one-sided, kept within the limit of monotonicity.
  const auto end = [](double inner, double step_at_end) {
    return std::clamp(1.5 * step_at_end - 0.5 * inner, 0.0, 3 * step_at_end);
  };
  slopes_[0] = n == 2 ? step(0) : end(slopes_[1], step(0));
  slopes_[n - 1] = n == 2 ? step(0) : end(slopes_[n - 2], step(n - 2));
}

double TimeAxis::in_segment(size_t i, double u) const {
  const double a = times_[i], b = times_[i + 1], u2 = u * u, u3 = u2 * u;
  return a * (2 * u3 - 3 * u2 + 1) + b * (3 * u2 - 2 * u3) + slopes_[i] * (u3 - 2 * u2 + u) +
         slopes_[i + 1] * (u3 - u2);
}

double TimeAxis::time_of(double index) const {
  const double end = count_ - 1, slack = 1e-9 * (1 + end);
  if (!(index >= -slack && index <= end + slack))
    fail(Code::out_of_domain, "frame index ", index, " is outside the series, 0 to ", end);
  index = std::clamp(index, 0.0, end);
  if (times_.empty()) return first_ + index * step_;
  if (times_.size() == 1) return times_[0];
  const auto i = std::min(static_cast<size_t>(index), times_.size() - 2);
  return in_segment(i, index - static_cast<double>(i));
}

double TimeAxis::slope_at(double index) const {
  if (times_.empty()) return step_;
  if (times_.size() == 1) return 1;
  const auto i = std::min(static_cast<size_t>(std::max(index, 0.0)), times_.size() - 2);
  const double u = index - static_cast<double>(i);
  return (times_[i + 1] - times_[i]) * 6 * u * (1 - u) + slopes_[i] * (3 * u * u - 4 * u + 1) +
         slopes_[i + 1] * (3 * u * u - 2 * u);
}

bool TimeAxis::holds(double time) const {
  const double span = last() - first(), slack = 1e-9 * (span + std::fabs(last()) * 1e-3);
  return time >= first() - slack && time <= last() + slack;
}

double TimeAxis::index_of(double time) const {
  if (!holds(time))
    fail(Code::out_of_domain, "time ", time, " is outside the series, ", first(), " to ", last());
  time = std::clamp(time, first(), last());
  if (times_.empty()) return std::clamp((time - first_) / step_, 0.0, count_ - 1);
  if (times_.size() == 1) return 0;
  const auto above = std::upper_bound(times_.begin(), times_.end(), time);
  const auto i = std::min(static_cast<size_t>(std::max<std::ptrdiff_t>(above - times_.begin() - 1, 0)),
                          times_.size() - 2);
  // The curve is monotone inside the segment, so that bisection finds the index to the last bit.
  double low = 0, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (in_segment(i, middle) <= time ? low : high) = middle;
  }
  return static_cast<double>(i) + (time == times_[i + 1] ? 1 : low);
}

} // namespace bccsplat
