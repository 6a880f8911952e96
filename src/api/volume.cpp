// SPDX-License-Identifier: Apache-2.0
// Opens, evaluates and verifies volumes.
#include <span>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/streams.h"
#include "api/structs.h"
#include "volume/frame_values.h"
#include "volume/values_at.h"
#include "volume/volume_source.h"

using namespace bccsplat;
using namespace bccsplat::api;

static_assert(sizeof(Vec4) == 4 * sizeof(double) && sizeof(std::array<float, 4>) == 4 * sizeof(float));

namespace {

using Opening = bccsplat_volume::Opening;

constexpr double least_shape = 1e-30;

// older: whose caches it begins with; null: none.
template<class Open>
std::unique_ptr<bccsplat_volume> open(bccsplat_device& device, Opening how, const bccsplat_volume* older,
                                      const Open& open_source) {
  Progress progress;
  watch(progress, how.token);
  progress.throw_if_cancelled();
  how.bytes = open_source();
  auto source = std::make_unique<VolumeSource>(how.bytes, device.read_turns, progress);
  VolumeSource& reads = *source;
  auto made = std::make_unique<bccsplat_volume>(&device, how, std::move(source));
  if (older) made->file.take_over(older->file);
  reads.opened();
  if (const std::string caches = made->file.describe_caches();
      !older || caches != older->file.describe_caches())
    device.log(BCCSPLAT_LOG_INFO, caches); // once, however often a file that grows is looked at
  progress.throw_if_cancelled();
  return made;
}

// All 0: as stored.
Vec3 read_shape(const double (&shape)[3]) {
  if (shape[0] == 0 && shape[1] == 0 && shape[2] == 0) return {1, 1, 1};
  for (const double factor : shape)
    if (!(factor >= least_shape && factor <= 1 / least_shape))
      fail(Code::invalid_argument, "bccsplat_volume_options.shape: ", factor,
           " is no factor from 1e-30 to 1e30; all 0: as stored");
  return {shape[0], shape[1], shape[2]};
}

template<class Open>
bccsplat_status open(bccsplat_device* device, const bccsplat_volume_options* options,
                     bccsplat_volume** volume, const Open& open_source) {
  return guard([&] {
    require(volume, "volume");
    *volume = nullptr;
    require(device, "device");
    const auto o = read_struct(options, "bccsplat_volume_options");
    Opening how;
    how.token = read_token(o.cancel_token);
    how.options = {o.kernel ? o.kernel : "", o.cache_bytes, device->max_sites, {}, read_shape(o.shape)};
    how.options.limits.salvage = o.salvage != 0, how.options.limits.salvage_unreadable = o.salvage == 2;
    *volume = open(*device, how, nullptr, open_source).release();
  });
}

// world: points are places in the world and times, else index units. missing: null where such points are an
// error.
void evaluate(const bccsplat_volume* volume, uint32_t channel, uint64_t n, const double* xyzt, float* values,
              float* gradients, bool world, uint64_t* missing) {
  require(volume, "volume");
  const Coefficients& all = volume->file.coefficients(channel, nullptr);
  if (missing) *missing = 0;
  if (n == 0) return;
  require(xyzt, "xyzt"), require(values, "values");
  require_count(n, sizeof(Vec4), "n");
  Progress progress;
  watch(progress, volume->token);
  progress.throw_if_cancelled();
  const std::span points(reinterpret_cast<const Vec4*>(xyzt), n);
  std::span<std::array<float, 4>> slopes;
  if (gradients) slopes = {reinterpret_cast<std::array<float, 4>*>(gradients), n};
  const Context context = volume->device->context(progress);
  const EvaluateMisses misses =
      world ? values_at_world(volume->file, channel, points, {values, n}, slopes, context)
            : values_at(volume->file, channel, points, {values, n}, slopes, context);
  volume->note_repeats(all);
  if (missing) {
    *missing = misses.outside + misses.holes;
    return;
  }
  if (misses.outside > 0)
    fail(Code::out_of_domain, misses.outside, " of ", n, " points lie outside the domain; ",
         first_outside(volume->file, points, world));
  if (misses.holes > 0) fail(Code::hole, misses.holes, " of ", n, " points lie in holes");
}

SampleBox read_box(const OpenVolume& volume, uint32_t channel, uint64_t frame, const uint64_t* begin,
                   const uint64_t* end) {
  (void)volume.channel(channel); // there has to be one
  const auto& dims = volume.lattice(0).dims;
  if (frame >= static_cast<uint64_t>(dims[3]))
    fail(Code::out_of_domain, "read_frame: frame ", frame, " of ", dims[3]);
  SampleBox box;
  for (size_t a = 0; a < 3; ++a) {
    const auto n = static_cast<uint64_t>(dims[a]);
    const uint64_t first = begin ? begin[a] : 0, last = end ? end[a] : n;
    if (last > n)
      fail(Code::out_of_domain, "read_frame: samples up to ", last, " of ", n, " along ", "xyz"[a]);
    if (first >= last)
      fail(Code::invalid_argument, "read_frame: no sample from ", first, " to before ", last, " along ",
           "xyz"[a]);
    box.begin[a] = static_cast<int32_t>(first), box.end[a] = static_cast<int32_t>(last);
  }
  return box;
}

} // namespace

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

bccsplat_status bccsplat_volume_reopen(const bccsplat_volume* volume, const bccsplat_read_stream* stream,
                                       bccsplat_volume** newer) {
  return guard([&] {
    require(newer, "newer");
    *newer = nullptr;
    require(volume, "volume");
    const Opening& how = volume->opening;
    const auto source = [&] {
      return stream ? std::shared_ptr<const ByteSource>(source_of(stream, "stream")) : how.bytes;
    };
    *newer = open(*volume->device.get(), how, volume, source).release();
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
  return guard([&] { evaluate(volume, channel, n, xyzt, values, gradients, false, nullptr); });
}

bccsplat_status bccsplat_volume_evaluate_world(const bccsplat_volume* volume, uint32_t channel, uint64_t n,
                                               const double* xyzt, float* values, float* gradients,
                                               uint64_t* missing) {
  return guard([&] { evaluate(volume, channel, n, xyzt, values, gradients, true, missing); });
}

bccsplat_status bccsplat_volume_read_frame(const bccsplat_volume* volume, uint32_t channel, uint64_t frame,
                                           const uint64_t* begin, const uint64_t* end, float* values) {
  return guard([&] {
    require(volume, "volume"), require(values, "values");
    if (!begin != !end) fail(Code::invalid_argument, "read_frame: begin and end are there together or not");
    const SampleBox box = read_box(volume->file, channel, frame, begin, end);
    Progress progress;
    watch(progress, volume->token);
    progress.throw_if_cancelled();
    read_frame(volume->file, channel, static_cast<int64_t>(frame), box, values,
               volume->device->context(progress));
  });
}

bccsplat_status bccsplat_volume_verify(const bccsplat_volume* volume, bccsplat_progress_fn progress,
                                       void* progress_user, bccsplat_verify_report* report) {
  return guard([&] {
    require(volume, "volume"), require(report, "report");
    Progress checking(progress_callback(progress, progress_user));
    watch(checking, volume->token);
    checking.throw_if_cancelled();
    const Bcc4VerifyResult result = volume->file.reader()->verify_all(volume->device->context(checking));
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
