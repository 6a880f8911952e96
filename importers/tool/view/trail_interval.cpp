// SPDX-License-Identifier: Apache-2.0
#include "tool/view/trail_interval.h"

#include <algorithm>
#include <cmath>

#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

// The frame that a volume shows at a time; before its series the first, after it the last. Frames of one that
// is periodic count on.
double frame_shown(const Volume& volume, double time) {
  const bccsplat_volume_info info = volume_info(volume);
  if (info.time_periodic == 0)
    return frame_index(volume, std::clamp(time, info.time_first, info.time_last), false);
  const double turn = info.time_end - info.time_first, turns = std::floor((time - info.time_first) / turn);
  return frame_index(volume, time - turns * turn, false) + turns * static_cast<double>(info.dims[3]);
}

// "A:B" as two numbers.
std::array<double, 2> parse_span(const std::string& option, const std::string& text) {
  const auto parts = split(text, ":");
  const auto from = parts.size() == 2 ? parse_number<double>(trim(parts[0])) : std::nullopt;
  const auto to = parts.size() == 2 ? parse_number<double>(trim(parts[1])) : std::nullopt;
  if (!from || !to || !std::isfinite(*from) || !std::isfinite(*to) || !(*from <= *to))
    fail_usage(option, " ", text, ": A:B is expected, two numbers that rise");
  return {*from, *to};
}

} // namespace

TrailInterval parse_trail_span(const std::string& option, const std::string& text) {
  TrailInterval t;
  std::string span(trim(text));
  t.frames = !span.empty() && span.back() == 'f';
  if (t.frames) span.pop_back();
  if (span.find(':') != std::string::npos) {
    const auto [from, to] = parse_span(option, span);
    t.from = from, t.to = to;
  } else {
    const double length = option_number<double>(option, span);
    if (!std::isfinite(length)) fail_usage(option, " ", text, ": a finite time is expected");
    t.from = std::min(0.0, -length), t.to = std::max(0.0, -length);
  }
  return t;
}

std::array<double, 2> trail_interval(const TrailInterval& t, bool index, const Volume& volume,
                                     const Cut& where) {
  if (!where.is_time_slice || t.frames || index) return {t.from, t.to};
  const auto frame = [&](double offset) { return frame_shown(volume, where.time + offset) - where.index; };
  return {frame(t.from), frame(t.to)};
}

std::array<double, 2> trail_interval_beside(const TrailInterval& t, bool index, const Volume& volume,
                                            const Cut& where, const Volume& other, const ClockChange& clock) {
  if (t.frames) return {t.from, t.to};
  const double last = last_index(volume_info(volume));
  const auto time = [&](double offset) {
    if (!index) return where.time + offset;
    return cut_at_index(volume, std::clamp(where.index + offset, 0.0, last)).time;
  };
  const double now = frame_shown(other, clock(where.time));
  return {frame_shown(other, clock(time(t.from))) - now, frame_shown(other, clock(time(t.to))) - now};
}

} // namespace bcc4
