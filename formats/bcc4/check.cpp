// SPDX-License-Identifier: Apache-2.0
// Checks the rules that a VolumeInfo keeps, which are the same for a caller's and for a file's.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>
#include <string>
#include <tuple>

#include "base/utf8.h"
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/counts.h"
#include "formats/bcc4/metadata.h"
#include "formats/bcc4/page.h"
#include "points/uneven_axes.h"

namespace bccsplat {
namespace {

constexpr int32_t max_planes = 1'000'000'000; // per axis, as in Lattice4::fit
constexpr int32_t max_lead = 254;
constexpr int32_t max_margin = 255;

// Bounds of coordinates and times as hosts hand them in: products of three are finite.
constexpr double farthest = 1e30, least_length = 1e-30;

[[nodiscard]] bool positive(double v) { return v > 0 && std::isfinite(v); }
[[nodiscard]] bool is_range(const Range& r) {
  return std::isfinite(r.low) && std::isfinite(r.high) && r.low <= r.high;
}

// name: "lattice", or that of a level.
void check_lattice(const StoredLattice& info, const std::string& name, Code code) {
  const Lattice4& l = info.lattice;
  const auto bad = [&](const auto&... why) { fail(code, name, ": ", why...); };
  if (l.kind != LatticeKind::d4star && l.kind != LatticeKind::bcc && l.kind != LatticeKind::cc)
    bad("unknown kind ", static_cast<int>(l.kind));
  if (l.space.bcc != (l.kind != LatticeKind::cc)) bad("the spatial lattice does not belong to its kind");
  unsigned __int128 samples = 1;
  for (const uint32_t n : l.dims) {
    if (n == 0) bad("a dimension is 0");
    samples *= n;
    if (samples > INT64_MAX) bad("more than 2^63 source samples");
  }
  for (size_t a = 0; a < 3; ++a) {
    const double end = l.domain_end(a);
    if (l.space.last[a] < 1 || l.space.last[a] > max_planes)
      bad("last plane ", l.space.last[a], " on axis ", a);
    if (!positive(l.space_step[a])) bad("distance of planes ", l.space_step[a], " on axis ", a);
    for (const int32_t n : {l.before[a], l.behind[a]})
      if (n < 0 || n > max_margin) bad(n, " planes outside the samples of axis ", a);
    if (l.space.bcc && l.before[a] % 2 != 0)
      bad(l.before[a], " planes before axis ", a, ", not an even number");
    if (l.inner_planes(a) < 1 || (end == 0 && l.before[a] + l.behind[a] > 0))
      bad("planes outside the samples of axis ", a, " leave none inside");
    if (l.turns(a) &&
        (l.dims[a] < 2 || l.before[a] + l.behind[a] > 0 || (l.space.bcc && l.space.planes(a) % 2 != 0)))
      bad("axis ", a, " of ", l.dims[a], " samples and ", l.space.planes(a), " planes, ",
          l.before[a] + l.behind[a], " of them outside, is not periodic");
    if (end > 0 && std::fabs(l.inner_planes(a) * l.space_step[a] - end) > 1e-9 * end)
      bad("the last plane of axis ", a, l.turns(a) ? " leads to one at " : " inside stands at ",
          l.inner_planes(a) * l.space_step[a], ", the last sample", l.turns(a) ? " to one" : "", " at ", end);
  }
  if (l.dims[3] == 1) {
    if (l.periodic) bad("one frame is not periodic");
    if (l.kind == LatticeKind::d4star || l.time_step != 0 || l.lead != 0 ||
        l.last_layer != l.space.cosets() - 1)
      bad("one frame needs a static lattice");
  } else {
    const double end = l.dims[3] - 1.0;
    if (l.kind == LatticeKind::bcc || !positive(l.time_step) || l.last_layer < 1 || l.last_layer > max_planes)
      bad(l.dims[3], " frames need a lattice in time");
    if (l.lead < 0 || l.lead > max_lead || l.lead % 2 != 0)
      bad(l.lead, " layers before the first frame, not an even number up to ", max_lead);
    if (l.periodic) {
      const double turn = l.layers() * l.time_step;
      if (l.lead != 0 || (l.space.bcc && l.layers() % 2 != 0) ||
          std::fabs(turn - l.dims[3]) > 1e-9 * l.dims[3])
        bad(l.layers(), " layers with ", l.lead, " before the first frame take ", turn, " frames, a turn of ",
            l.dims[3]);
    } else if (l.layer_frame(l.last_layer) < end - 1e-8 * end)
      bad("the last layer stands at frame ", l.layer_frame(l.last_layer), ", the last frame is ", end);
  }
  check_planes_and_layers(l, name, code);
  if (info.slab_layers < 1 || info.slab_layers > max_slab_layers) bad(info.slab_layers, " layers in a slab");
  unsigned __int128 bricks = 1;
  for (const int32_t n : slot_dims(StoredLattice{l})) bricks *= static_cast<unsigned>(n);
  if (bricks > UINT32_MAX) bad("more than 2^32 bricks in a layer");
  if (4096 * bricks * static_cast<unsigned>(l.layers()) > INT64_MAX) bad("more than 2^63 sites");
}

// Refuses a level that is not the same series on a lattice coarser than the one before.
void check_level(const VolumeInfo& info, int number, Code code) {
  const auto& level = static_cast<const LevelInfo&>(info.level(number));
  const std::string name = concat("level ", number);
  const Lattice4 &l = level.lattice, &finer = info.level(number - 1).lattice;
  if (l.kind != info.lattice.kind || l.dims != info.lattice.dims || l.periodic != info.lattice.periodic ||
      l.space.periodic != info.lattice.space.periodic)
    fail(code, name, ": not of the kind, the samples and the ends of level 0");
  check_lattice(level, name, code);
  for (size_t a = 0; a < 3; ++a)
    if (l.dims[a] > 1 && l.space_step[a] < finer.space_step[a])
      fail(code, name, ": planes of axis ", a, " are ", l.space_step[a], " apart, those of the level before ",
           finer.space_step[a]);
  if (l.time_step < finer.time_step)
    fail(code, name, ": layers are ", l.time_step, " frames apart, those of the level before ",
         finer.time_step);
  if (level.channels.size() != info.channels.size())
    fail(code, name, ": ", level.channels.size(), " channels of ", info.channels.size());
}

// Refuses counts of a level that cannot be.
void check_level_counts(const VolumeInfo& info, int number, Code code) {
  const LevelInfo& level = info.levels[static_cast<size_t>(number) - 1];
  const uint64_t sites = level.lattice.sites();
  for (const LevelChannel& c : level.channels)
    if (c.sites_kept > sites || c.holes > c.sites_kept || !is_range(c.kept_range))
      fail(code, "level ", number, ": ", c.sites_kept, " kept sites of ", sites, ", ", c.holes,
           " holes, samples from ", c.kept_range.low, " to ", c.kept_range.high);
}

void check_errors(const VolumeInfo& info, Code code) {
  const auto key = [](const MeasuredError& e) { return std::tuple(e.channel, e.level, e.kind); };
  for (size_t i = 0; i < info.errors.size(); ++i) {
    const MeasuredError& e = info.errors[i];
    if (e.channel >= info.channels.size() || e.level > info.levels.size() ||
        e.kind > MeasuredError::corrected || (i > 0 && !(key(info.errors[i - 1]) < key(e))))
      fail(code, "measured errors of channel ", e.channel, ", level ", e.level, ", kind ", e.kind);
    for (const double v : {e.rmse, e.largest, e.range})
      if (!(v >= 0 && std::isfinite(v))) fail(code, "a measured error is ", v);
  }
}

// Refuses what is finite, but no coordinate or time that anything can be drawn at.
void check_far(double v, const char* name) {
  if (std::isfinite(v) && std::fabs(v) > farthest)
    fail(Code::limit_exceeded, name, v, ", the limit is ", farthest);
}

void check_affine(const Affine3& affine, Code code) {
  const auto entry = [&](double v) {
    if (!std::isfinite(v)) fail(code, "affine: not finite");
    check_far(v, "affine: ");
  };
  for (const Vec3& row : affine.linear)
    for (const double v : row) entry(v);
  for (const double v : affine.offset) entry(v);
  const double determinant = affine.determinant();
  if (determinant == 0) fail(code, "affine: determinant 0");
  if (const double voxel = std::cbrt(std::fabs(determinant));
      !(voxel >= least_length / 2 && voxel <= 2 * farthest))
    fail(Code::limit_exceeded, "affine: a mean voxel of ", voxel, ", the limits are ", least_length / 2,
         " and ", 2 * farthest);
}

// Refuses coordinates that do not put each sample at a place of its own, one beyond the other.
void check_axis(const VolumeInfo& info, size_t axis, Code code) {
  const std::vector<double>& at = info.axes[axis].coordinates;
  const auto bad = [&](const auto&... why) { fail(code, "axis ", "xyz"[axis], ": ", why...); };
  if (at.empty()) return;
  if (at.size() != info.lattice.dims[axis] || at.size() < 2)
    bad(at.size(), " coordinates for ", info.lattice.dims[axis], " samples");
  if (info.lattice.turns(axis)) bad("it is periodic, and its samples are unevenly spaced");
  const double sign = at.back() < at.front() ? -1 : 1;
  for (size_t i = 0; i < at.size(); ++i)
    if (!std::isfinite(at[i]) || (i > 0 && !(sign * at[i] > sign * at[i - 1])))
      bad("coordinate ", at[i], " of sample ", i, " is not beyond the one before");
  if (!std::isfinite(at.back() - at.front())) bad("its coordinates are too far apart");
  for (const double v : at) check_far(v, "axes: a coordinate of ");
  const std::vector<double> even = even_positions(at);
  for (size_t i = 1; i < even.size(); ++i)
    if (!(even[i] > even[i - 1]))
      bad("coordinates ", at[i - 1], " and ", at[i], " are one place beside a range of ",
          at.back() - at.front());
}

void check_times(const TimeMap& t, uint32_t frames, Code code) {
  if (t.uniform) {
    if (!std::isfinite(t.first) || !positive(t.step) || !t.times.empty())
      fail(code, "times: first ", t.first, ", step ", t.step);
    check_far(t.first, "times: first "), check_far(t.step, "times: step ");
    if (t.step < least_length)
      fail(Code::limit_exceeded, "times: step ", t.step, ", the limit is ", least_length);
    return;
  }
  if (t.times.size() != frames) fail(code, "times: ", t.times.size(), " for ", frames, " frames");
  for (size_t i = 0; i < t.times.size(); ++i)
    if (!std::isfinite(t.times[i]) || (i > 0 && !(t.times[i] > t.times[i - 1])))
      fail(code, "times: time ", t.times[i], " of frame ", i, " does not rise");
  for (const double v : t.times) check_far(v, "times: ");
}

void check_text(const std::string& s, Code code) {
  if (!is_utf8(s)) fail(code, "text is not UTF-8: ", to_utf8(s));
}

void check_attributes(const VolumeInfo& info, Code code) {
  std::set<std::string> keys;
  for (const auto& [key, value] : info.attributes) {
    check_text(key, code), check_text(value, code);
    if (key.empty() || !keys.insert(key).second)
      fail(code, "attribute key \"", key, "\" is empty or stands twice");
  }
}

// Checks texts and parameters of the whole series.
void check_description(const VolumeInfo& info, Code code) {
  for (const auto* s : {&info.spatial_unit, &info.time.unit, &info.time.epoch, &info.recommended_kernel})
    check_text(*s, code);
  for (const SourceInfo& s : info.sources) check_text(s.name, code);
  for (const AxisInfo& a : info.axes) check_text(a.unit, code);
  check_attributes(info, code);
}

void check_tail(const VolumeInfo& info, Code code) {
  if (info.tail->slabs < 0 || info.tail->slabs > info.slabs())
    fail(code, "the tail counts ", info.tail->slabs, " slabs of ", info.slabs());
  const size_t channels = info.channels.size();
  for (size_t i = 0; i < channels * info.level_count(); ++i) {
    const uint64_t all = i < channels ? info.channels[i].clamped
                                      : info.levels[i / channels - 1].channels[i % channels].clamped;
    if (info.tail->clamped.at(i) > all)
      fail(code, "the tail counts ", info.tail->clamped[i], " clamped samples of ", all);
  }
}

// Checks what writers that go on need: the writes of a part, the counts and the tail of a series.
void check_progress(const VolumeInfo& info, Code code) {
  if (info.part)
    for (const PartWrite& w : info.part->writes)
      if (const int32_t slabs = info.level(w.level).slabs(); w.slab >= slabs)
        fail(code, "part: a write of slab ", w.slab, " of ", slabs);
  if (info.counts && (info.counts->slabs < 0 || info.counts->slabs > info.slabs()))
    fail(code, "the counts are of ", info.counts->slabs, " slabs of ", info.slabs());
  if (info.tail) check_tail(info, code);
}

// Checks texts, ranges, histogram and percentiles of a channel.
void check_values(const ChannelInfo& c, uint32_t frames, Code code) {
  const auto bad = [&](const auto&... why) { fail(code, "channel ", c.name, ": ", why...); };
  for (const auto* s : {&c.name, &c.quantity, &c.unit}) check_text(*s, code);
  for (const Range* r : {&c.source_range, &c.kept_range, &c.histogram_range})
    if (!is_range(*r)) bad("range from ", r->low, " to ", r->high);
  if (!c.histogram.empty() && c.histogram.size() != 256) bad("a histogram of ", c.histogram.size(), " bins");
  for (size_t i = 0; i < c.percentiles.size(); ++i) {
    const Percentile& p = c.percentiles[i];
    if (!(p.percent >= 0 && p.percent <= 100) || !std::isfinite(p.value) ||
        (i > 0 && (p.percent <= c.percentiles[i - 1].percent || p.value < c.percentiles[i - 1].value)))
      bad("percentiles do not rise");
  }
  if (!c.frames.empty() && c.frames.size() != frames) bad("ranges of ", c.frames.size(), " frames");
  for (const Range& r : c.frames)
    if (!is_range(r)) bad("range of a frame from ", r.low, " to ", r.high);
}

void check_corrections(const ChannelInfo& c, uint32_t frames, Code code) {
  const auto bad = [&](const auto&... why) { fail(code, "channel ", c.name, ": corrections ", why...); };
  const ResidualInfo& fix = c.residuals;
  if (!(fix.step >= 0 && fix.bound >= 0) || !std::isfinite(fix.step) || !std::isfinite(fix.bound))
    bad("in steps of ", fix.step, ", bound ", fix.bound);
  if (fix.base && !std::isfinite(*fix.base)) bad("of a field above ", *fix.base);
  for (const auto* blocks : {&fix.frames, &fix.tables})
    if (!blocks->empty() && (blocks->size() != frames || fix.step == 0))
      bad("of ", blocks->size(), " frames");
  if (fix.shape > CorrectionShape::smooth) bad("of shape ", static_cast<int>(fix.shape));
}

// A frame without a block adds nothing, others no more than their samples.
void check_sums(const ChannelInfo& c, const VolumeInfo& info, Code code) {
  const auto most = [&](std::initializer_list<const std::vector<BlockRef>*> blocks) {
    const bool any = std::any_of(blocks.begin(), blocks.end(), [](const auto* b) { return !b->empty(); });
    return any ? info.cc_samples() : 0;
  };
  const uint64_t fixes = most({&c.residuals.frames, &c.residuals.tables}), missing = most({&c.masks});
  if (c.sums->corrections > fixes || c.sums->missing > missing)
    fail(code, "channel ", c.name, ": ", c.sums->corrections, " corrections of ", fixes, " samples, ",
         c.sums->missing, " missing of ", missing);
}

// Tiles hold integers of one or two bytes.
void check_tiles(const VolumeInfo& info, Code code) {
  for (const LevelInfo& level : info.levels)
    if (level.tile_edge != info.tile_edge) fail(code, "levels with chunks of other sizes than level 0");
  const bool tiles = info.tile_edge > 1;
  if (tiles && std::find(tile_edges.begin(), tile_edges.end(), info.tile_edge) == tile_edges.end())
    fail(code, "tiles of ", info.tile_edge, " bricks along an axis, not 2, 4 or 8");
  for (const ChannelInfo& c : info.channels) {
    if (!std::isfinite(c.wavelet_error) || c.wavelet_error < 0 ||
        (tiles ? c.wavelet_error == 0 : c.wavelet_error > 0))
      fail(code, "channel ", c.name, ": wavelet coefficients with an error of ", c.wavelet_error);
    if (tiles && c.type != ValueType::u8 && c.type != ValueType::u16)
      fail(code, "channel ", c.name, ": wavelet coefficients are of samples of type u8 or u16");
    if (c.linear && (!tiles || info.lattice.space.bcc))
      fail(code, "channel ", c.name, ": linear samples without wavelet coefficients on a Cartesian lattice");
  }
}

} // namespace

void check_axes(const VolumeInfo& info, Code code) {
  for (size_t a = 0; a < 3; ++a) check_axis(info, a, code);
  if (info.has_uneven_axes() && !info.spatial_unit.empty())
    fail(code, "the axes are unevenly spaced, and space has the unit ", info.spatial_unit,
         "; axes have their own");
}

void check_channel(const ChannelInfo& c, Code code) {
  const auto bad = [&](const auto&... why) { fail(code, "channel ", c.name, ": ", why...); };
  if (c.type < ValueType::u8 || c.type > ValueType::f32) bad("unknown value type ", static_cast<int>(c.type));
  if (c.source_type > SourceType::u32) bad("unknown source type ", static_cast<int>(c.source_type));
  if (!std::isfinite(c.air) || !(c.threshold >= 0) || !std::isfinite(c.threshold)) bad("air or threshold");
  const double bias = c.offset - c.air;
  if (c.type == ValueType::u8 || c.type == ValueType::u16) {
    if (!positive(c.scale) || !std::isfinite(c.offset)) bad("scale ", c.scale, ", offset ", c.offset);
    if (std::fabs(bias) > 0x1p22 * c.scale) bad("air is more than 2^22 steps from the offset");
    if (!(c.scale * 65535 + std::fabs(bias) < 0x1p127)) bad("values beyond the range of floats");
  } else if (c.scale != 1 || !(bias == 0 || (c.type == ValueType::f16 && c.offset == 0))) {
    bad("floats need scale 1 and offset = air");
  }
}

void check_fixed(const VolumeInfo& info, Code code) {
  check_lattice(info, "lattice", code);
  if (!positive(info.scale) || !positive(info.time_scale)) fail(code, "lattice: scales must be positive");
  if (info.channels.empty()) fail(code, "no channels");
  std::set<std::string> names;
  for (const ChannelInfo& c : info.channels) {
    if (c.name.empty()) fail(code, "a channel has no name");
    if (!names.insert(c.name).second) fail(code, "two channels are named ", c.name);
    check_channel(c, code);
  }
  if (info.levels.size() > most_levels) fail(code, info.levels.size(), " levels, at most ", most_levels);
  for (int l = 1; l < info.level_count(); ++l) check_level(info, l, code);
  check_tiles(info, code);
}

void check_info(const VolumeInfo& info, Code code) {
  check_fixed(info, code);
  if (info.part && info.lattice.periodic) fail(code, "a part of a periodic series");
  const uint32_t frames = info.lattice.dims[3];
  check_affine(info.affine, code);
  check_axes(info, code);
  check_times(info.time, frames, code);
  check_description(info, code);
  check_progress(info, code);
  check_errors(info, code);
  for (int l = 1; l < info.level_count(); ++l) check_level_counts(info, l, code);
  const uint64_t sites = info.lattice.sites();
  for (const ChannelInfo& c : info.channels) {
    check_values(c, frames, code);
    check_corrections(c, frames, code);
    if (c.sums) check_sums(c, info, code);
    if (!c.masks.empty() && c.masks.size() != frames)
      fail(code, "channel ", c.name, ": masks of ", c.masks.size(), " frames");
    if (c.sites_kept > sites || c.holes > c.sites_kept)
      fail(code, "channel ", c.name, ": ", c.sites_kept, " kept sites of ", sites, ", ", c.holes, " holes");
  }
}

void tidy(VolumeInfo& info) {
  const auto mend = [](Range& r) {
    if (!is_range(r)) r = {};
  };
  const auto text = [](std::string& s) { s = to_utf8(s); };
  for (auto* s : {&info.spatial_unit, &info.time.unit, &info.time.epoch, &info.recommended_kernel}) text(*s);
  for (SourceInfo& s : info.sources) text(s.name);
  for (AxisInfo& a : info.axes) text(a.unit);
  for (auto& [key, value] : info.attributes) text(key), text(value);
  for (size_t i = 0; i < info.attributes.size();) {
    const auto later = std::find_if(info.attributes.begin() + i + 1, info.attributes.end(),
                                    [&](const auto& a) { return a.first == info.attributes[i].first; });
    if (later == info.attributes.end())
      ++i;
    else
      info.attributes.erase(info.attributes.begin() + i);
  }
  for (ChannelInfo& c : info.channels) {
    for (auto* s : {&c.name, &c.quantity, &c.unit}) text(*s);
    mend(c.source_range), mend(c.histogram_range);
    for (Range& r : c.frames) mend(r);
    for (size_t i = 0; i < c.percentiles.size(); ++i) {
      double& v = c.percentiles[i].value;
      if (!std::isfinite(v)) v = 0;
      if (i > 0) v = std::max(v, c.percentiles[i - 1].value);
    }
  }
}

} // namespace bccsplat
