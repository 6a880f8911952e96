// SPDX-License-Identifier: Apache-2.0
// Opens a file, divides its cache among chunks, coefficients, corrections and masks, and makes coefficients
// as they are first asked for.
#include "volume/open_volume.h"

#include <algorithm>
#include <cmath>

#include "base/machine.h"
#include "base/text.h"
#include "formats/bcc4/read/frame_sources.h"
#include "formats/bcc4/read/unchanged_slabs.h"
#include "formats/bcc4/same_coding.h"
#include "motion/moving_series.h"
#include "slice/part.h"
#include "volume/volume_cache.h"

namespace bccsplat {
namespace {

// The largest parts of the cache that corrections and masks take, for each channel that has some.
constexpr uint64_t corrections_part = 8, masks_part = 16;
constexpr uint64_t budget_parts = 4; // caches that nobody chose take one of these (default_cache_bytes)

// Up to the end of the domain: of a periodic series that is frame 0 again, and as long after the last frame
// as frames are apart in the mean.
TimeAxis time_axis(const VolumeInfo& info) {
  const Lattice4& l = info.lattice;
  if (info.time.uniform) return {info.time.first, info.time.step, l.last_frame() + 1};
  std::vector<double> times = info.time.times;
  if (l.periodic) times.push_back(times.back() + (times.back() - times.front()) / (l.dims[3] - 1.0));
  return TimeAxis(std::move(times));
}

// Returns a level's share of the cache of level 0: a level has an eighth of the sites of the one before, in
// bricks that are not all full.
uint64_t cache_of_level(uint64_t bytes, uint32_t level) { return bytes >> (2 * level); }

// The kernel a caller named, or what the file recommends, or the default.
std::string choose_kernel(const VolumeInfo& info, const char* asked) {
  return asked && *asked ? asked : info.recommended_kernel;
}

// The box around the points of the domain, index units; points outside count as the nearest inside.
IndexBox box_around(std::span<const Vec4> points, const Lattice4& lattice) {
  IndexBox box;
  for (size_t a = 0; a < 3; ++a) box.begin[a] = lattice.domain_end(a);
  for (const Vec4& p : points)
    for (size_t a = 0; a < 3; ++a) {
      const double x = std::isnan(p[a]) ? 0 : std::clamp(p[a], 0.0, lattice.domain_end(a));
      box.begin[a] = std::min(box.begin[a], x), box.end[a] = std::max(box.end[a], x);
    }
  return box;
}

BrickBox bricks_of_values(std::span<const Vec4> points, const Lattice4& lattice, const Kernel& kernel) {
  return bricks_around(box_around(points, lattice), lattice, sites_in_reach(lattice, kernel));
}

double part_of_bricks(const BrickBox& box, const Lattice3& lattice) {
  double part = 1;
  for (size_t a = 0; a < 3; ++a) {
    const int32_t all = (lattice.dims(0)[a] + brick_edge - 1) / brick_edge;
    part *= static_cast<double>(std::min(box.end[a], all) - box.begin[a]) / all;
  }
  return part;
}

bool covers(const BrickBox& outer, const BrickBox& inner) {
  for (size_t a = 0; a < 3; ++a)
    if (inner.begin[a] < outer.begin[a] || inner.end[a] > outer.end[a]) return false;
  return true;
}

UnevenAxes uneven_axes(const VolumeInfo& info) {
  return UnevenAxes({info.axes[0].coordinates, info.axes[1].coordinates, info.axes[2].coordinates});
}

// A kernel that is not made for the lattice fails where it is used.
VolumeCache cache_to_play(const Bcc4Reader& reader, const Kernel& kernel) {
  try {
    return playing_cache(reader, kernel);
  } catch (const Error&) {
    return {};
  }
}

Affine3 shaped(Affine3 affine, const Vec3& shape) {
  for (size_t r = 0; r < 3; ++r) affine.linear[r] = shape[r] * affine.linear[r], affine.offset[r] *= shape[r];
  return affine;
}

} // namespace

OpenVolume::OpenVolume(std::unique_ptr<ByteSource> source, const VolumeOptions& options, MemoryBudget& memory)
    : reader_(Bcc4Reader::open(std::move(source), options.limits)), times_(time_axis(reader_->info())),
      affine_(shaped(reader_->info().affine, options.shape)),
      axes_(std::make_shared<const UnevenAxes>(uneven_axes(reader_->info()))),
      kernel_(make_kernel(choose_kernel(reader_->info(), options.kernel.c_str()))),
      recommended_kernel_(make_kernel(reader_->info().recommended_kernel).name) {
  const uint64_t sites = info().lattice.sites();
  if (sites > options.max_sites)
    fail(Code::limit_exceeded, "the file declares ", sites, " lattice sites, the device allows ",
         options.max_sites);
  const VolumeCache playing = cache_to_play(*reader_, kernel_);
  const uint64_t cache = options.cache_bytes ? options.cache_bytes
                                             : default_cache_bytes(playing, memory.limit(), machine_memory());
  const VolumeCache share = share_cache(cache, playing);
  for (int level = 0; level < info().level_count(); ++level)
    samples_.push_back(std::make_unique<Bcc4Samples>(reader_, memory, cache_of_level(share.chunks, level),
                                                     RelativeTo::base, level));
  cache_bytes_ = share.coefficients, whole_cache_bytes_ = cache, playing_cache_bytes_ = playing.bytes();
  for (const ChannelInfo& c : info().channels) {
    const auto index = static_cast<int>(corrections_.size());
    // A bound is kept by slices off the time axis, which are mended, even where no sample was corrected.
    const bool corrected = c.residuals.any() || c.residuals.bound > 0;
    corrections_.push_back(
        corrected ? std::make_unique<Corrections>(std::make_unique<Bcc4Corrections>(reader_, index), memory,
                                                  cache / corrections_part)
                  : nullptr);
    masks_.push_back(!c.masks.empty() ? std::make_unique<Masks>(std::make_unique<Bcc4Masks>(reader_, index),
                                                                memory, cache / masks_part)
                                      : nullptr);
  }
  labels_ = std::make_unique<std::atomic<Labels>[]>(info().channels.size());
}

void OpenVolume::take_over(const OpenVolume& older) {
  reader_->take_over(*older.reader_);
  repeats_told_ = older.repeats_told_.load();
  const UnchangedSlabs unchanged(*older.reader_, *reader_);
  for (size_t level = 0; level < std::min(samples_.size(), older.samples_.size()); ++level)
    samples_[level]->take_over(*older.samples_[level], unchanged);
  if (same_coding(info(), older.info())) take_over_coefficients(older, unchanged);
}

void OpenVolume::take_over_coefficients(const OpenVolume& older, const UnchangedSlabs& unchanged) {
  const std::scoped_lock lock(older.mutex_); // nobody else has this one yet
  const auto take = [&](const Coefficients& made, const Coefficients& from, const ChannelLevel& at) {
    made.take_over(from, [&](int32_t layer) { return unchanged.layer(at, layer); });
  };
  const auto at = [](const Key& key) {
    return ChannelLevel{static_cast<int>(std::get<0>(key)), static_cast<int>(std::get<2>(key))};
  };
  for (const auto& [key, from] : older.coefficients_) {
    const auto& [channel, kernel, level] = key;
    auto made =
        make_coefficients(channel, kernel_of(kernel.c_str()), level, {}, cache_of_level(cache_bytes_, level));
    take(*made, *from, at(key));
    coefficients_[key] = std::move(made);
  }
  for (const auto& [key, part] : older.parts_) {
    const auto& [channel, kernel, level] = key;
    std::shared_ptr<const Coefficients> made = make_coefficients(
        channel, kernel_of(kernel.c_str()), level, part.region, cache_of_level(cache_bytes_, level));
    take(*made, *part.coefficients, at(key));
    parts_[key] = {part.region, std::move(made)};
  }
  for (const auto& [channel, probed] : older.probed_) {
    std::shared_ptr<const Coefficients> made;
    if (probed.part.coefficients) {
      made =
          make_coefficients(channel, kernel_, 0, probed.part.region, probed.part.coefficients->cache_bytes());
      take(*made, *probed.part.coefficients, {static_cast<int>(channel), 0});
    }
    probed_[channel] = {{probed.part.region, std::move(made)}, probed.made};
  }
}

std::string OpenVolume::describe_caches() const {
  return concat("volume: caches of ", whole_cache_bytes_, " bytes, ", cache_bytes_,
                " of them for each channel's coefficients; playing needs ", playing_cache_bytes_);
}

std::optional<std::string> OpenVolume::note_repeats(const Coefficients& coefficients) const {
  if (coefficients.layers_repeated() == 0 || repeats_told_.exchange(true)) return std::nullopt;
  if (whole_cache_bytes_ >= playing_cache_bytes_)
    return concat("volume: layers are read or made again, for the caches of ", whole_cache_bytes_,
                  " bytes are those of a series that plays forward; moments in other orders need a "
                  "larger cache_bytes");
  return concat("volume: layers are read or made again, which caches of ", whole_cache_bytes_,
                " bytes had let go; cache_bytes of ", playing_cache_bytes_, " (or a memory_budget of ",
                budget_parts * playing_cache_bytes_, " that chooses it) keeps them while the series plays");
}

const ChannelInfo& OpenVolume::channel(uint32_t index) const {
  if (index >= info().channels.size())
    fail(Code::not_found, "channel ", index, " of a file with ", info().channels.size());
  return info().channels[index];
}

std::optional<bool> OpenVolume::known_labels(uint32_t channel) const {
  if (channel >= info().channels.size()) return std::nullopt;
  const Labels known = labels_[channel];
  return known == Labels::unknown ? std::nullopt : std::optional(known == Labels::yes);
}

void OpenVolume::note_labels(uint32_t channel, bool labels) const {
  labels_[channel] = labels ? Labels::yes : Labels::no;
}

const Lattice4& OpenVolume::lattice(uint32_t level) const {
  if (level >= samples_.size())
    fail(Code::not_found, "level ", level, " of a file whose last one is ", samples_.size() - 1);
  return samples_[level]->lattice();
}

Kernel OpenVolume::kernel_of(const char* name) const { return name && *name ? make_kernel(name) : kernel_; }

std::unique_ptr<Coefficients> OpenVolume::make_coefficients(uint32_t channel_index, Kernel k, uint32_t level,
                                                            const BrickBox& region, uint64_t cache) const {
  const ChannelInfo& c = channel(channel_index);
  const SampleSource& samples_of_level = samples(level);
  // What a coefficient adds to a constant region is its own value: below half the threshold it cannot matter
  // beside air.
  const int index = channel_index;
  const float prune = samples_of_level.base(index) == c.air ? c.threshold / 2 : 0;
  const bool own = k.name == make_kernel(choose_kernel(info(), nullptr)).name;
  auto made = std::make_unique<Coefficients>(samples_of_level, index, std::move(k), prune, cache, region);
  if (own && level == 0) made->set_corrections(corrections_[channel_index].get());
  made->set_masks(masks_[channel_index].get());
  return made;
}

const Coefficients& OpenVolume::coefficients(uint32_t channel_index, const char* kernel_name,
                                             uint32_t level) const {
  Kernel k = kernel_of(kernel_name);
  const Key key{channel_index, k.name, level};
  const std::scoped_lock lock(mutex_);
  if (const auto it = coefficients_.find(key); it != coefficients_.end()) return *it->second;
  (void)lattice(level);
  auto made = make_coefficients(channel_index, std::move(k), level, {}, cache_of_level(cache_bytes_, level));
  return *(coefficients_[key] = std::move(made));
}

std::shared_ptr<const Coefficients> OpenVolume::coefficients(uint32_t channel_index, const char* kernel_name,
                                                             uint32_t level, const BrickBox& region,
                                                             bool keep) const {
  if (region == BrickBox{})
    return {std::shared_ptr<void>{}, &coefficients(channel_index, kernel_name, level)};
  Kernel k = kernel_of(kernel_name);
  const Key key{channel_index, k.name, level};
  const std::scoped_lock lock(mutex_);
  if (const auto it = parts_.find(key); it != parts_.end() && it->second.region == region)
    return it->second.coefficients;
  (void)lattice(level);
  std::shared_ptr<const Coefficients> made =
      make_coefficients(channel_index, std::move(k), level, region, cache_of_level(cache_bytes_, level));
  if (keep) parts_[key] = {region, made};
  return made;
}

double OpenVolume::share_around(std::span<const Vec4> points) const {
  const Lattice4& lattice = this->lattice(0);
  return part_of_bricks(bricks_of_values(points, lattice, kernel_), lattice.space);
}

const motion::MovingSeries& OpenVolume::motion(const Coefficients& coefficients) const {
  const std::lock_guard lock(mutex_);
  auto& known = motion_[&coefficients];
  if (!known) known = std::make_shared<const motion::MovingSeries>(coefficients, times_);
  return *known;
}

std::shared_ptr<const Coefficients> OpenVolume::coefficients_at(uint32_t channel_index,
                                                                std::span<const Vec4> points) const {
  constexpr double few = 0.25; // of all bricks
  std::shared_ptr<const Coefficients> all = coefficients(channel_index, nullptr, 0, BrickBox{});
  const Lattice4& lattice = this->lattice(0);
  const BrickBox region = bricks_of_values(points, lattice, kernel_);
  const double share = part_of_bricks(region.widened(), lattice.space); // of the samples these are made of
  const std::scoped_lock lock(mutex_);
  Probed& probed = probed_[channel_index];
  if (share > few || probed.made >= 1) return all;
  if (probed.part.coefficients && covers(probed.part.region, region)) return probed.part.coefficients;
  probed.made += share;
  probed.part = {region, make_coefficients(channel_index, kernel_, 0, region,
                                           static_cast<uint64_t>(few * static_cast<double>(cache_bytes_)))};
  return probed.part.coefficients;
}

} // namespace bccsplat
