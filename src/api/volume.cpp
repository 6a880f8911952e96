// SPDX-License-Identifier: Apache-2.0
// Opens a file, divides its cache among chunks, coefficients, corrections and masks, and makes coefficients
// as they are first asked for, by channel, kernel and level; evaluates and verifies it.
#include <span>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/streams.h"
#include "api/structs.h"
#include "api/volume_source.h"
#include "base/machine.h"
#include "field/coefficients/volume_cache.h"
#include "field/evaluate.h"

using namespace bccsplat;
using namespace bccsplat::api;

static_assert(sizeof(Vec4) == 4 * sizeof(double) && sizeof(std::array<float, 4>) == 4 * sizeof(float));

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

// The kernel a caller named, or the file's: stored coefficients fix it, else its recommendation, else the
// default.
std::string choose_kernel(const VolumeInfo& info, const char* asked) {
  if (asked && *asked) return asked;
  if (!info.coefficient_kernel.empty()) return info.coefficient_kernel;
  return info.recommended_kernel;
}

// A kernel that is not made for the lattice fails where it is used.
VolumeCache cache_to_play(const Bcc4Reader& reader, const Kernel& kernel) {
  try {
    return playing_cache(reader, kernel);
  } catch (const Error&) {
    return {};
  }
}

template<class Open>
bccsplat_status open(bccsplat_device* device, const bccsplat_volume_options* options,
                     bccsplat_volume** volume, const Open& open_source) {
  return guard([&] {
    require(volume, "volume");
    *volume = nullptr;
    require(device, "device");
    const auto o = read_struct(options, "bccsplat_volume_options");
    const Token token = read_token(o.cancel_token);
    Progress progress;
    watch(progress, token);
    progress.throw_if_cancelled();
    auto source = std::make_unique<VolumeSource>(open_source(), device->read_turns, progress);
    VolumeSource& reads = *source;
    auto made = std::make_unique<bccsplat_volume>(device, std::move(source), o);
    reads.opened();
    progress.throw_if_cancelled();
    made->token = token;
    *volume = made.release();
  });
}

} // namespace

bccsplat_volume::bccsplat_volume(bccsplat_device* owner, std::unique_ptr<ByteSource> source,
                                 const bccsplat_volume_options& options)
    : device(owner),
      reader(Bcc4Reader::open(std::move(source),
                              {.salvage = options.salvage != 0, .salvage_unreadable = options.salvage == 2})),
      times(time_axis(reader->info())), kernel(make_kernel(choose_kernel(reader->info(), options.kernel))),
      recommended_kernel(make_kernel(reader->info().recommended_kernel).name) {
  const uint64_t sites = info().lattice.sites();
  if (sites > owner->max_sites)
    fail(Code::limit_exceeded, "the file declares ", sites, " lattice sites, the device allows ",
         owner->max_sites);
  const VolumeCache playing = cache_to_play(*reader, kernel);
  const uint64_t cache = options.cache_bytes
                             ? options.cache_bytes
                             : default_cache_bytes(playing, owner->memory.limit(), machine_memory());
  const VolumeCache share = share_cache(cache, playing);
  for (int level = 0; level < info().level_count(); ++level)
    samples.push_back(std::make_unique<Bcc4Samples>(
        reader, owner->memory, cache_of_level(share.chunks, level), RelativeTo::base, level));
  cache_bytes = share.coefficients, whole_cache_bytes = cache, playing_cache_bytes = playing.bytes();
  for (const ChannelInfo& c : info().channels) {
    const auto index = static_cast<int>(corrections_of.size());
    // A bound is kept by slices off the time axis, which are mended, even where no sample was corrected.
    const bool corrected = c.residuals.any() || c.residuals.bound > 0;
    corrections_of.push_back(
        corrected ? std::make_unique<Corrections>(reader, index, owner->memory, cache / corrections_part)
                  : nullptr);
    masks_of.push_back(!c.masks.empty()
                           ? std::make_unique<Masks>(reader, index, owner->memory, cache / masks_part)
                           : nullptr);
  }
  owner->log(BCCSPLAT_LOG_INFO,
             concat("volume: caches of ", cache, " bytes, ", share.coefficients,
                    " of them for each channel's coefficients; playing needs ", playing.bytes()));
}

void bccsplat_volume::tell_repeats(const Coefficients& coefficients) const {
  if (coefficients.layers_repeated() == 0 || repeats_told_.exchange(true)) return;
  if (whole_cache_bytes >= playing_cache_bytes)
    device->log(BCCSPLAT_LOG_INFO,
                concat("volume: layers are read or made again, for the caches of ", whole_cache_bytes,
                       " bytes are those of a series that plays forward; moments in other orders need a "
                       "larger cache_bytes"));
  else
    device->log(BCCSPLAT_LOG_INFO,
                concat("volume: layers are read or made again, which caches of ", whole_cache_bytes,
                       " bytes had let go; cache_bytes of ", playing_cache_bytes, " (or a memory_budget of ",
                       budget_parts * playing_cache_bytes,
                       " that chooses it) keeps them while the series plays"));
}

const ChannelInfo& bccsplat_volume::channel(uint32_t index) const {
  if (index >= info().channels.size())
    fail(Code::not_found, "channel ", index, " of a file with ", info().channels.size());
  return info().channels[index];
}

const Lattice4& bccsplat_volume::lattice(uint32_t level) const {
  if (level >= samples.size())
    fail(Code::not_found, "level ", level, " of a file whose last one is ", samples.size() - 1);
  return samples[level]->lattice();
}

Kernel bccsplat_volume::kernel_of(const char* name) const {
  return name && *name ? make_kernel(name) : kernel;
}

std::unique_ptr<Coefficients> bccsplat_volume::make_coefficients(uint32_t channel_index, Kernel k,
                                                                 uint32_t level, const BrickBox& region,
                                                                 const SampleSource& samples_of_level,
                                                                 uint64_t cache) const {
  const ChannelInfo& c = channel(channel_index);
  // What a coefficient adds to a constant region is its own value: below half the threshold it cannot matter
  // beside air.
  const int index = channel_index;
  const float prune = samples_of_level.base(index) == c.air ? c.threshold / 2 : 0;
  const bool own = k.name == make_kernel(choose_kernel(info(), nullptr)).name;
  auto made = std::make_unique<Coefficients>(samples_of_level, index, std::move(k), prune, cache, region);
  if (own && level == 0) made->set_corrections(corrections_of[channel_index].get());
  made->set_masks(masks_of[channel_index].get());
  return made;
}

const Coefficients& bccsplat_volume::coefficients(uint32_t channel_index, const char* kernel_name,
                                                  uint32_t level) const {
  Kernel k = kernel_of(kernel_name);
  const Key key{channel_index, k.name, level};
  const std::scoped_lock lock(mutex_);
  if (const auto it = coefficients_.find(key); it != coefficients_.end()) return *it->second;
  (void)lattice(level);
  auto made = make_coefficients(channel_index, std::move(k), level, {}, *samples[level],
                                cache_of_level(cache_bytes, level));
  return *(coefficients_[key] = std::move(made));
}

std::shared_ptr<const Coefficients> bccsplat_volume::coefficients(uint32_t channel_index,
                                                                  const char* kernel_name, uint32_t level,
                                                                  const BrickBox& region) const {
  if (region == BrickBox{})
    return {std::shared_ptr<void>{}, &coefficients(channel_index, kernel_name, level)};
  Kernel k = kernel_of(kernel_name);
  const Key key{channel_index, k.name, level};
  const std::scoped_lock lock(mutex_);
  if (const auto it = parts_.find(key); it != parts_.end() && it->second.region == region)
    return it->second.coefficients;
  (void)lattice(level);
  std::shared_ptr<const Coefficients> made = make_coefficients(
      channel_index, std::move(k), level, region, *samples[level], cache_of_level(cache_bytes, level));
  parts_[key] = {region, made};
  return made;
}

std::unique_ptr<Coefficients> bccsplat_volume::rehearsal(uint32_t channel_index, const char* kernel_name,
                                                         uint32_t level, const BrickBox& region,
                                                         const SampleSource& source, bool holding) const {
  Kernel k = kernel_of(kernel_name);
  const Key key{channel_index, k.name, level};
  auto made = make_coefficients(channel_index, std::move(k), level, region, source, UINT64_MAX);
  if (!holding) return made;
  const std::scoped_lock lock(mutex_);
  if (region == BrickBox{}) {
    if (const auto it = coefficients_.find(key); it != coefficients_.end())
      made->pretend_to_hold(*it->second);
  } else if (const auto it = parts_.find(key); it != parts_.end() && it->second.region == region) {
    made->pretend_to_hold(*it->second.coefficients);
  }
  return made;
}

extern "C" {

bccsplat_status bccsplat_volume_open_file(bccsplat_device* device, const char* path,
                                          const bccsplat_volume_options* options, bccsplat_volume** volume) {
  return open(device, options, volume, [&] {
    require(path, "path");
    return open_file_source(path);
  });
}

bccsplat_status bccsplat_volume_open_memory(bccsplat_device* device, const void* bytes, uint64_t size,
                                            const bccsplat_volume_options* options,
                                            bccsplat_volume** volume) {
  return open(device, options, volume, [&] {
    require(bytes, "bytes");
    require_count(size, 1, "size");
    return open_memory_source({static_cast<const std::byte*>(bytes), size});
  });
}

bccsplat_status bccsplat_volume_open_stream(bccsplat_device* device, const bccsplat_read_stream* stream,
                                            const bccsplat_volume_options* options,
                                            bccsplat_volume** volume) {
  return open(device, options, volume, [&] {
    require(stream, "stream");
    return source_of(stream, "stream");
  });
}

void bccsplat_volume_retain(bccsplat_volume* volume) { retain(volume); }
void bccsplat_volume_release(bccsplat_volume* volume) { release(volume); }

bccsplat_status bccsplat_volume_evaluate(const bccsplat_volume* volume, uint64_t n, const double* xyzt,
                                         float* values, float* gradients) {
  return bccsplat_volume_evaluate_channel(volume, 0, n, xyzt, values, gradients);
}

bccsplat_status bccsplat_volume_evaluate_channel(const bccsplat_volume* volume, uint32_t channel, uint64_t n,
                                                 const double* xyzt, float* values, float* gradients) {
  return guard([&] {
    require(volume, "volume");
    const Coefficients& c = volume->coefficients(channel, nullptr);
    if (n == 0) return;
    require(xyzt, "xyzt"), require(values, "values");
    require_count(n, sizeof(Vec4), "n");
    Progress progress;
    watch(progress, volume->token);
    progress.throw_if_cancelled();
    const std::span points(reinterpret_cast<const Vec4*>(xyzt), n);
    std::span<std::array<float, 4>> slopes;
    if (gradients) slopes = {reinterpret_cast<std::array<float, 4>*>(gradients), n};
    const EvaluateMisses misses =
        evaluate4(c, points, {values, n}, slopes, volume->device->context(progress));
    volume->tell_repeats(c);
    if (misses.outside > 0)
      fail(Code::out_of_domain, misses.outside, " of ", n, " points lie outside the domain");
    if (misses.holes > 0) fail(Code::hole, misses.holes, " of ", n, " points lie in holes");
  });
}

bccsplat_status bccsplat_volume_verify(const bccsplat_volume* volume, bccsplat_progress_fn progress,
                                       void* progress_user, bccsplat_verify_report* report) {
  return guard([&] {
    require(volume, "volume"), require(report, "report");
    Progress checking(progress_callback(progress, progress_user));
    watch(checking, volume->token);
    checking.throw_if_cancelled();
    const Bcc4VerifyResult result = volume->reader->verify_all(volume->device->context(checking));
    bccsplat_verify_report out{};
    out.chunks = result.chunks, out.chunks_damaged = result.chunks_damaged,
    out.bytes_checked = result.bytes_checked;
    out.damages = result.damage.size(), out.unreadable = result.unreadable.size();
    if (!result.damage.empty()) out.first_damaged_offset = result.damage.front().offset;
    if (!result.unreadable.empty()) out.first_unreadable_offset = result.unreadable.front().offset;
    for (const auto* places : {&result.damage, &result.unreadable})
      for (const Bcc4Damage& d : *places) volume->device->log(BCCSPLAT_LOG_WARNING, d.message);
    if (!result.survivors.empty()) volume->device->log(BCCSPLAT_LOG_WARNING, result.survivors);
    write_struct(report, out, "report");
    if (out.unreadable > 0)
      fail(Code::io_error, "verify: ", out.unreadable, " places could not be read, the first at offset ",
           out.first_unreadable_offset, ": ", result.unreadable.front().message);
  });
}

} // extern "C"
