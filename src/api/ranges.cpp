// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "api/handles.h"
#include "api/ranges.h"
#include "api/slice_options.h"
#include "api/structs.h"
#include "volume/read_ranges.h"

using namespace bccsplat;
using namespace bccsplat::api;

void bccsplat::api::check_ranges(uint32_t flags, const uint64_t* ranges, uint64_t capacity) {
  if (capacity > 0) require(ranges, "ranges");
  if (flags & ~uint32_t{BCCSPLAT_RANGES_MISSING})
    fail(Code::invalid_argument, "get_ranges: unknown flags ", flags & ~uint32_t{BCCSPLAT_RANGES_MISSING});
}

void bccsplat::api::write_ranges(std::span<const ByteRange> found, uint64_t* ranges, uint64_t capacity,
                                 uint64_t* count) {
  for (size_t i = 0; i < std::min<uint64_t>(capacity, found.size()); ++i)
    ranges[2 * i] = found[i].offset, ranges[2 * i + 1] = found[i].size;
  if (count) *count = found.size();
}

extern "C" bccsplat_status bccsplat_volume_get_ranges(const bccsplat_volume* volume,
                                                      const bccsplat_hyperplane* hyperplane,
                                                      const bccsplat_slice_options* options, uint32_t flags,
                                                      uint64_t* ranges, uint64_t capacity, uint64_t* count) {
  return guard([&] {
    require(volume, "volume");
    check_ranges(flags, ranges, capacity);
    const auto o = read_struct(options, "bccsplat_slice_options");
    HypersliceOptions cut = read_slice_options(o, volume->file);
    const Hyperplane h = read_hyperplane(hyperplane, o, cut);
    const Token token = read_token(o.cancel_token);
    Progress progress(progress_callback(o.progress, o.progress_user), true);
    watch(progress, token), watch(progress, volume->token);
    progress.throw_if_cancelled();
    Progress unheard(progress, 0, 0); // its parts take no time that is worth telling
    const SliceRequest asked = request_slice(volume->file, o.channel, o.kernel, o.level, h, cut, false);
    const auto found = read_ranges(volume->file, asked, (flags & BCCSPLAT_RANGES_MISSING) != 0,
                                   volume->device->context(unheard));
    progress.report(1);
    write_ranges(found, ranges, capacity, count);
  });
}
