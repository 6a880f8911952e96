// SPDX-License-Identifier: Apache-2.0
#include "store/settings.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

void check_periodic(const WriterSettings& s) {
  if (s.dims[3] < 2)
    fail(Code::invalid_argument, "writer: a periodic series needs the number of its frames in dims[3], ",
         "at least 2, as a whole number of layers makes a turn");
  if (s.continuity == Continuity::append)
    fail(Code::unsupported, "writer: a periodic series ends where it begins, so that none goes on; ",
         "write it anew");
  if (s.part)
    fail(Code::unsupported, "writer: a periodic series is not written in parts, as its first layers need ",
         "the last frames; write it in one go");
  if (s.live_slabs > 0)
    fail(Code::unsupported,
         "writer: a periodic series is not looked at while it is written, as its first layers ", "come last");
}

// Labels have no values in between and no means: what would make some is refused.
void check_labels(const WriterSettings& s) {
  const bool own = std::all_of(s.scales.begin(), s.scales.end(), [](double scale) { return scale == 1; });
  for (const ChannelSettings& c : s.channels) {
    if (!c.labels.value_or(false)) continue;
    if (s.lattice != LatticeKind::cc || !own || s.wavelets)
      fail(Code::unsupported, "channel ", c.name,
           ": labels come back whole from samples of lattice CC at distance 1 alone; store them so, or "
           "call them quantities");
    if (s.levels > 0)
      fail(Code::unsupported, "channel ", c.name,
           ": labels have no means, of which coarser levels are made; store none of these (levels 0), or "
           "call them quantities");
  }
}

} // namespace

void require_rising(std::span<const double> times) {
  for (size_t i = 0; i < times.size(); ++i)
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
      fail(Code::invalid_argument, "part.times: time ", times[i], " of frame ", i, " does not rise");
}

void check_settings(const WriterSettings& s, bool to_stream) {
  if (to_stream && s.continuity != Continuity::none)
    fail(Code::unsupported, "writer: a stream's unfinished work is the host's own; partial must be DEFAULT");
  for (size_t a = 0; a < 3; ++a)
    if (s.dims[a] == 0) fail(Code::invalid_argument, "writer: dims[", a, "] is 0");
  if (s.lowpass && s.lattice == LatticeKind::cc)
    fail(Code::invalid_argument, "writer: a low-pass is of use on D4* and BCC only");
  if (s.live_slabs > 0 && s.part)
    fail(Code::unsupported,
         "writer: parts of a series, and what continues a file, are seen when they are finished");
  if (s.levels < 0 || s.levels > most_levels)
    fail(Code::invalid_argument, "writer: ", s.levels, " coarser levels, not 0 to ", most_levels);
  for (const ChannelSettings& c : s.channels)
    if (!(c.abs_error >= 0 && std::isfinite(c.abs_error)))
      fail(Code::invalid_argument, "writer: abs_error must be finite and not negative");
  if (!(s.psnr >= 0 && std::isfinite(s.psnr)))
    fail(Code::invalid_argument, "writer: psnr must be finite and not negative");
  if ((s.must_measure() || s.wavelets) && s.dims[3] == 0)
    fail(Code::invalid_argument,
         "writer: a bound, measuring or wavelets need the number of frames in dims[3]; where it is "
         "not known yet give the most that may come, and end with finish_short");
  if (s.ends == Ends::periodic) check_periodic(s);
  check_labels(s);
  for (size_t a = 0; a < 3; ++a)
    if (s.turning[a] && !s.axes[a].coordinates.empty())
      fail(Code::unsupported, "writer: axis ", "xyz"[a],
           " is periodic, and its coordinates are unevenly spaced; a periodic axis takes none");
  for (size_t a = 0; a < 3; ++a)
    if (s.turning[a] && (s.dims[a] < 2 || (s.faces == Faces::along && s.faces_along[a])))
      fail(Code::invalid_argument,
           "writer: a periodic axis has two samples at least, and no faces to predict");
  if (s.lattice == LatticeKind::bcc && s.dims[3] != 1)
    fail(Code::invalid_argument, "writer: lattice BCC holds one frame; set dims[3] to 1 or choose D4STAR");
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const ChannelSettings& channel = s.channels[c];
    if (channel.name.empty()) fail(Code::invalid_argument, "channel ", c, ": the name is empty");
    for (size_t other = 0; other < c; ++other)
      if (s.channels[other].name == channel.name)
        fail(Code::invalid_argument, "two channels are named ", channel.name);
    if (!(channel.threshold >= 0 && std::isfinite(channel.threshold)) || !std::isfinite(channel.air))
      fail(Code::invalid_argument, "channel ", channel.name,
           ": air and air_threshold must be finite, the threshold >= 0");
    if (channel.range && !(channel.range->low < channel.range->high && std::isfinite(channel.range->low) &&
                           std::isfinite(channel.range->high)))
      fail(Code::invalid_argument, "channel ", channel.name, ": range must be finite and rise");
  }
}

} // namespace bccsplat
