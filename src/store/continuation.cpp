// SPDX-License-Identifier: Apache-2.0
// Compares an old file with the series that goes on, finds where it has what stays, and copies that. What was
// counted of it is taken from the file where it tells, and counted again from its chunks where they are
// samples.
#include "store/continuation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <vector>

#include "fit/axis/site_axis.h"
#include "fit/resample/holes.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/labels_attribute.h"
#include "store/journal_options.h"
#include "store/part_report.h"
#include "store/series_part.h"

namespace bccsplat {
namespace {

constexpr size_t batch_chunks = 64; // decoded together: at most 8 MiB of samples

// The sites that masks make fills, of the layers of one slab; none where there are no masks.
class MaskedSites {
 public:
  MaskedSites(const Bcc4Reader& file, int channel, const Context& context)
      : file_(file), channel_(channel), context_(context) {}

  void enter(int32_t slab) {
    const VolumeInfo& info = file_.info();
    if (info.channels[channel_].masks.empty()) return;
    layers_.clear();
    for (int32_t m = 0; m < info.layers_of(slab); ++m) {
      const double at = info.lattice.layer_frame(slab * info.slab_layers + m);
      const auto frame = nearest_sample(at, info.lattice.dims[3]);
      if (layers_.empty() || frame != frame_) sites_ = of_frame(frame);
      frame_ = frame;
      layers_.push_back(sites_);
    }
  }
  // Returns the mask of a brick of layer `m` of the slab; null: none.
  [[nodiscard]] const BrickMask* of(int32_t m, int coset, size_t slot) const {
    if (layers_.empty()) return nullptr;
    const auto& masks = (*layers_[m])[coset];
    return masks.empty() ? nullptr : masks[slot].get();
  }

 private:
  [[nodiscard]] std::shared_ptr<const SiteMasks> of_frame(int64_t frame) const {
    const Lattice4& lattice = file_.info().lattice;
    HoleMap map;
    for (size_t a = 0; a < 3; ++a) map.region.end[a] = lattice.dims[a];
    map.memory = Reservation(context_.memory, map.region.samples(), "missing data");
    file_.mask_runs(channel_, frame, [&](uint64_t begin, uint64_t end) {
      map.missing.resize(map.region.samples());
      std::fill(map.missing.begin() + begin, map.missing.begin() + end, uint8_t{1});
    });
    return std::make_shared<const SiteMasks>(mark_sites(map, lattice));
  }

  const Bcc4Reader& file_;
  int channel_;
  const Context& context_;
  int64_t frame_ = -1;
  std::shared_ptr<const SiteMasks> sites_; // of that frame
  std::vector<std::shared_ptr<const SiteMasks>> layers_;
};

// Returns whether no sample of a channel is data.
bool all_missing(const Bcc4Reader& file, int channel) {
  const auto& masks = file.info().channels[channel].masks;
  const auto& n = file.info().lattice.dims;
  for (uint64_t f = 0; f < masks.size(); ++f) {
    uint64_t missing = 0;
    file.mask_runs(channel, f, [&](uint64_t begin, uint64_t end) { missing += end - begin; });
    if (missing != uint64_t{n[0]} * n[1] * n[2]) return false;
  }
  return !masks.empty();
}

// Counts the samples of the slabs 0 .. end - 1 as the fit did.
LayerCounts count_slabs(const Bcc4Reader& file, int channel, int32_t end, const Context& context) {
  const ChannelInfo& info = file.info().channels[channel];
  // Single sites of air may be kept among others; they are not counted as samples.
  const SampleCoder coder(info);
  const float air = coder.decode(coder.codes().air);
  const bool air_is_none = !(info.threshold > 0 && std::fabs(air) > info.threshold);
  LayerCounts report;
  report.samples = SampleHistogram(info);
  const Lattice4& lattice = file.info().lattice;
  for (int32_t layer = 0; layer < end * file.info().slab_layers; ++layer)
    report.sites_total += lattice.space.sites(lattice.coset(layer));
  auto counted = std::make_unique<Brick>();
  // fills: sites that masks make fills; not counted as samples.
  const auto count = [&](const Brick& brick, const BrickMask* fills) {
    counted->value = brick.value, counted->kept = brick.kept;
    counted->hole = brick.hole ? std::make_unique<BrickMask>(*brick.hole) : nullptr;
    for (size_t site = 0; site < brick_sites; ++site)
      if (counted->value[site] == air && air_is_none && !counted->is_hole(static_cast<int>(site)))
        counted->kept[site / 16] = static_cast<uint16_t>(counted->kept[site / 16] & ~(1u << (site % 16)));
    report.sites_kept += counted->count();
    if (counted->hole)
      for (const uint16_t row : *counted->hole) report.holes += std::popcount(row);
    if (fills) counted->hole = std::make_unique<BrickMask>(*fills);
    report.samples.add(*counted);
  };
  MaskedSites masked(file, channel, context);
  for (int32_t slab = 0; slab < end; ++slab) {
    const std::vector<Bcc4Chunk> chunks = file.chunks(channel, slab);
    masked.enter(slab);
    for (size_t first = 0; first < chunks.size(); first += batch_chunks) {
      const auto batch = std::span(chunks).subspan(first, std::min(batch_chunks, chunks.size() - first));
      const auto read = file.read_chunks(channel, batch, context);
      for (size_t i = 0; i < batch.size(); ++i)
        for (int layer = 0; layer < file.info().slab_layers; ++layer)
          if (const auto brick = file.brick(channel, *read[i], layer)) {
            const int coset = lattice.coset(slab * file.info().slab_layers + layer);
            const Int3 at = file.brick_position(batch[i].slot);
            count(*brick,
                  masked.of(layer, coset, BrickLayer(lattice.space, coset).slot(at[0], at[1], at[2])));
          }
      context.progress.check();
    }
  }
  return report;
}

// Returns what the file tells of the samples that its first `slabs` slabs of wavelets were made of; none
// where it does not, or in words of another version.
std::optional<std::vector<LayerCounts>> told_counts(const VolumeInfo& info, int32_t slabs) {
  if (!info.counts || info.counts->slabs != slabs) return std::nullopt;
  try {
    std::vector<LayerCounts> counts;
    const size_t streams = info.channels.size() * info.level_count();
    for (PartChannelReport& c : read_part_report(info.counts->counts, streams).channels)
      counts.push_back(std::move(c.fit.lasting));
    return counts;
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool any_clamped(const VolumeInfo& info) {
  const auto clamped = [](const auto& c) { return c.clamped > 0; };
  return std::any_of(info.channels.begin(), info.channels.end(), clamped) ||
         std::any_of(info.levels.begin(), info.levels.end(), [&](const LevelInfo& level) {
           return std::any_of(level.channels.begin(), level.channels.end(), clamped);
         });
}

// Throws unless the file says the same times of its frames as the series that goes on.
void require_equal_times(const std::string& path, const VolumeInfo& was, std::span<const double> times) {
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (uint32_t f = 0; f < was.lattice.dims[3]; ++f)
    if (!(std::fabs(was.time.at(f) - times[f]) <= 1e-6 * step))
      fail(Code::wrong_state, path, ": its frame ", f, " is at time ", was.time.at(f),
           ", that of the series at ", times[f]);
}

} // namespace

void require_open_end(const VolumeInfo& was, const std::string& path) {
  if (was.lattice.periodic)
    fail(Code::unsupported, path, ": its series is periodic and ends where it begins, so that none goes on; ",
         "import all anew");
}

namespace {

template<class... What> [[noreturn]] void refuse_other(const std::string& path, const What&... what) {
  fail(Code::wrong_state, path, ": ", what..., "; import all anew");
}

void require_same_lattice(const VolumeInfo& was, const VolumeInfo& now, const std::string& path) {
  const Lattice4 &a = was.lattice, &b = now.lattice;
  if (a.is_static()) refuse_other(path, "it has a single frame, which is no series that could go on");
  if (a.kind != b.kind)
    refuse_other(path, "its lattice is ", name_of(a.kind), ", that of the series to be appended ",
                 name_of(b.kind));
  for (size_t axis = 0; axis < 3; ++axis) {
    if (a.dims[axis] != b.dims[axis])
      refuse_other(path, "it has ", a.dims[axis], " samples along ", "xyz"[axis],
                   ", the series to be appended ", b.dims[axis]);
    if (a.space.periodic[axis] != b.space.periodic[axis])
      refuse_other(path, "either it or the series to be appended is periodic along ", "xyz"[axis]);
    if (a.before[axis] != b.before[axis] || a.behind[axis] != b.behind[axis] ||
        a.space.last[axis] != b.space.last[axis])
      refuse_other(path, "it has ", a.space.planes(axis), " planes along ", "xyz"[axis],
                   ", the series to be appended ", b.space.planes(axis),
                   ": another lattice distance, or other faces");
  }
  if (a.time_step != b.time_step)
    refuse_other(path, "its layers are ", a.time_step, " frames apart, those to be appended ", b.time_step);
  if (a.lead != b.lead)
    refuse_other(path, "it has ", a.lead, " layers before frame 0, the series to be appended ", b.lead);
  if (!(a.space == b.space) || was.slab_layers != now.slab_layers || was.tile_edge != now.tile_edge)
    refuse_other(path, "the lattices of its series and of the one to be appended differ");
}

// Coordinates that differ by less than this part of the closest samples' distance are the same.
constexpr double same_place = 1e-6;

void require_same_axis(const VolumeInfo& was, const VolumeInfo& now, size_t axis, const std::string& path) {
  const auto &a = was.axes[axis].coordinates, &b = now.axes[axis].coordinates;
  if (a.size() != b.size())
    refuse_other(path, "along ", "xyz"[axis], " its samples are ", a.empty() ? "evenly" : "unevenly",
                 " spaced, those of the series to be appended ", b.empty() ? "evenly" : "unevenly");
  double closest = std::numeric_limits<double>::infinity();
  for (size_t i = 1; i < a.size(); ++i) closest = std::min(closest, std::fabs(a[i] - a[i - 1]));
  for (size_t i = 0; i < a.size(); ++i)
    if (!(std::fabs(a[i] - b[i]) <= same_place * closest))
      refuse_other(path, "its sample ", i, " along ", "xyz"[axis], " is at ", a[i],
                   ", that of the series to be appended at ", b[i]);
}

// What both tell must be the same.
void require_same_unit(const char* what, const std::string& was, const std::string& now,
                       const std::string& path) {
  if (!was.empty() && !now.empty() && was != now)
    refuse_other(path, "its ", what, " are in ", was, ", those of the series to be appended in ", now);
}

// Throws where a corner of the samples lies elsewhere in the world.
void require_same_affine(const VolumeInfo& was, const VolumeInfo& now, const std::string& path) {
  constexpr double rounding = 0.01; // of a voxel, in the mean
  const double voxel = std::cbrt(std::fabs(was.affine.determinant()));
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 at{};
    for (size_t a = 0; a < 3; ++a)
      if (corner >> a & 1) at[a] = was.lattice.dims[a] - 1.0;
    if (!(length(now.affine.point(at) - was.affine.point(at)) <= rounding * voxel))
      refuse_other(path, "its samples lie elsewhere in the world than those of the series to be appended");
  }
}

void require_same_channel(const VolumeInfo& was, const VolumeInfo& now, size_t c, const std::string& path) {
  const ChannelInfo &x = was.channels[c], &y = now.channels[c];
  const auto differs = [&](const char* what, const auto& of_file, const auto& of_series) {
    refuse_other(path, "channel ", c, " (", x.name, "): its ", what, " is ", of_file,
                 ", that of the series to be appended ", of_series);
  };
  if (x.name != y.name) differs("name", x.name, y.name);
  if (x.air != y.air) differs("air", x.air, y.air);
  if (x.threshold != y.threshold) differs("air_threshold", x.threshold, y.threshold);
  if (x.type != y.type) differs("type on disk", static_cast<int>(x.type), static_cast<int>(y.type));
  if (x.scale != y.scale) differs("step from code to code", x.scale, y.scale);
  if (x.offset != y.offset) differs("value of code 0", x.offset, y.offset);
  require_same_unit("values", x.unit, y.unit, path);
  const auto of_file = said_labels(was, x.name), of_series = said_labels(now, y.name);
  if (of_file && of_series && *of_file != *of_series)
    refuse_other(path, "channel ", c, " (", x.name,
                 "): either its values or those of the series to be appended are labels");
  if (x.wavelet_error != y.wavelet_error) differs("error of wavelets", x.wavelet_error, y.wavelet_error);
}

} // namespace

void require_continuable(const VolumeInfo& was, const VolumeInfo& now, uint32_t frames,
                         const std::string& path) {
  if (was.part) fail(Code::wrong_state, path, ": a part of a series; join all parts first");
  if (was.unfinished) fail(Code::wrong_state, path, ": an unfinished series; write it to its end first");
  require_same_lattice(was, now, path);
  for (size_t a = 0; a < 3; ++a) require_same_axis(was, now, a, path);
  require_same_affine(was, now, path);
  require_same_unit("places", was.spatial_unit, now.spatial_unit, path);
  require_same_unit("times", was.time.unit, now.time.unit, path);
  if (frames > 0 && was.lattice.dims[3] > now.lattice.dims[3])
    refuse_other(path, "it has ", was.lattice.dims[3], " frames, the longer series ", now.lattice.dims[3]);
  const auto same_layers = [](const StoredLattice& x, const StoredLattice& y) {
    return x.slab_layers == y.slab_layers && x.lattice.space == y.lattice.space &&
           x.lattice.before == y.lattice.before && x.lattice.behind == y.lattice.behind;
  };
  if (!std::equal(was.levels.begin(), was.levels.end(), now.levels.begin(), now.levels.end(), same_layers))
    refuse_other(path, "its coarser levels are others than those of the series to be appended");
  if (was.channels.size() != now.channels.size())
    refuse_other(path, "it has ", was.channels.size(), " channels, the series to be appended ",
                 now.channels.size());
  for (size_t c = 0; c < was.channels.size(); ++c) require_same_channel(was, now, c, path);
}

Continuation::Continuation(const Bcc4Reader& old, const WriterSettings& settings, FitOptions options)
    : old_(old) {
  const VolumeInfo& was = info();
  const PartSettings& part = *settings.part;
  const auto refuse = [&](const auto&... why) {
    fail(Code::wrong_state, settings.path, ": ", why..., "; give all frames, without a part");
  };
  const uint32_t done = was.lattice.dims[3];
  if (!part.block.all_space())
    fail(Code::unsupported, settings.path, ": a series goes on with whole frames, not with blocks of them");
  const uint32_t first = part.block.first_frame(), end = part.block.end_frame();
  if (first != done || end != settings.dims[3] || end < done)
    fail(Code::invalid_argument, settings.path, ": it has ", done, " frames, and the series ",
         settings.dims[3], ": the part to be appended is ", done, " to ", settings.dims[3],
         " (excluded), not ", first, " to ", end);
  if (was.lattice.is_static()) refuse("a single frame is not continued");
  if (settings.bounds_samples() || settings.psnr > 0 || settings.measure == Measure::all)
    refuse("a bound is checked on every frame");
  for (const ChannelInfo& channel : was.channels)
    if (channel.frames.size() != done)
      refuse("it was made of layers");
    else if (channel.residuals != ResidualInfo{})
      refuse("its frames are held to a bound by corrections");
  require_rising(part.times);
  require_equal_times(settings.path, was, part.times);
  options.lead = was.lattice.lead, options.margins = was.lattice.before;
  lattice_ = lattice_of(options, options.dims[3]);
  rest_ = rest_of_series(lattice_, options, done);
  const bool wavelets = was.tile_edge > 1;
  if (!wavelets && any_clamped(was) && !(was.tail && was.tail->slabs == slabs()))
    refuse("it does not tell where samples were clamped, as newer files do");
  if (wavelets && slabs() > 0 && !(told_ = told_counts(was, slabs())))
    refuse("it does not tell of the samples that its wavelets were made of, as files of this version do");
  begin_earlier(part.early_frames, rest_.fit);
  find_places();
}

// Finds where the old file has its slabs that stay, and the masks that a writer of all frames has written by
// the last of them, or that are of frames which do not come again.
void Continuation::find_places() {
  const auto channels = static_cast<int>(info().channels.size());
  for (int32_t slab = 0; slab < slabs(); ++slab)
    for (int c = 0; c < channels; ++c)
      for (int level = 0; level < info().level_count(); ++level)
        if (const auto chunks = old_.chunks({c, level}, slab); !chunks.empty())
          slab_places_.push_back({chunks.front().offset, slab, {c, level}, 0});
  std::sort(slab_places_.begin(), slab_places_.end(),
            [](const Place& a, const Place& b) { return a.offset < b.offset; });
  const uint64_t last = slab_places_.empty() ? 0 : slab_places_.back().offset;
  std::set<uint64_t> known;
  uint64_t at = 0;
  for (uint32_t f = 0; f < info().lattice.dims[3]; ++f)
    for (int c = 0; c < channels; ++c) {
      const auto& masks = info().channels[c].masks;
      const uint64_t offset = masks.empty() || masks[f].stored == 0 ? 0 : masks[f].offset;
      if (known.insert(offset).second) at = std::max(at, offset);
      if (at >= last && f >= rest_.fit.first_given) return;
      mask_places_.push_back({at, PartWrite::mask, c, f});
      masks_end_ = {f, c + 1};
    }
}

void Continuation::copy_what_stays(Bcc4Writer& container, Progress& progress) const {
  std::vector<Place> order;
  std::merge(mask_places_.begin(), mask_places_.end(), slab_places_.begin(), slab_places_.end(),
             std::back_inserter(order), [](const Place& a, const Place& b) { return a.offset < b.offset; });
  for (const Place& p : order) {
    if (p.slab == PartWrite::mask)
      container.copy_mask(p.at.channel, p.frame, old_);
    else
      container.copy_slab(p.slab, p.at, old_);
    progress.check();
  }
}

std::vector<LayerCounts> Continuation::old_counts(const Context& context) const {
  const VolumeInfo& was = info();
  if (told_) return *told_;
  std::vector<LayerCounts> counts;
  for (size_t c = 0; c < was.channels.size(); ++c) {
    counts.push_back(count_slabs(old_, static_cast<int>(c), slabs(), context));
  }
  counts.resize(was.channels.size() * was.level_count());
  if (slabs() > 0 && was.tail)
    for (size_t i = 0; i < counts.size(); ++i) counts[i].clamped = was.tail->clamped[i];
  return counts;
}

void Continuation::add_to(FitReport& report, const Context& context) const {
  const VolumeInfo& was = info();
  PartReport all, rest;
  const std::vector<LayerCounts> counts = old_counts(context);
  for (size_t c = 0; c < counts.size(); ++c) {
    FitChannelReport old;
    static_cast<LayerCounts&>(old) = old.lasting = counts[c];
    old.clamped_slabs.assign(slabs(), 0);
    if (slabs() > 0) old.clamped_slabs[0] = old.clamped;
    rest.channels.push_back({std::move(report.channels[c]), 0, {}, {}});
    if (c >= was.channels.size()) { // of a coarser level
      all.channels.push_back({std::move(old), 0, {}, {}});
      continue;
    }
    const ChannelInfo& channel = was.channels[c];
    old.source_range = channel.source_range;
    const bool only_holes = channel.holes > 0 && channel.holes == channel.sites_kept;
    const bool none = only_holes || (channel.sites_kept == 0 && all_missing(old_, static_cast<int>(c)));
    old.any_finite = !(none && channel.source_range == Range{});
    old.frames = channel.frames;
    old.source_samples = was.cc_samples();
    old.cc_relevant = channel.cc_relevant;
    all.channels.push_back({std::move(old), 0, {}, {}});
  }
  add_part_report(all, std::move(rest), {was.lattice.dims[3], static_cast<size_t>(slabs())});
  for (size_t c = 0; c < counts.size(); ++c) report.channels[c] = std::move(all.channels[c].fit);
}

} // namespace bccsplat
