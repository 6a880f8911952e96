// SPDX-License-Identifier: Apache-2.0
#include "tool/view/picture_cut.h"

#include <algorithm>
#include <cmath>

#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

// Part of the samples that a box is worth cutting for.
constexpr double worth_cutting = 0.75;

// The samples around what a picture sees; none where that is most of them.
std::optional<SampleBox> seen_region(const bccsplat_picture_needs& needs, const bccsplat_volume_info& v) {
  SampleBox box;
  double share = 1;
  for (size_t a = 0; a < 3; ++a) {
    box.begin[a] = static_cast<uint64_t>(needs.box[a]);
    box.dims[a] = static_cast<uint64_t>(std::ceil(needs.box[a + 3])) - box.begin[a] + 1;
    share *= static_cast<double>(box.dims[a]) / static_cast<double>(v.dims[a]);
  }
  return share <= worth_cutting ? std::optional(box) : std::nullopt;
}

} // namespace

PictureCut cut_for_picture(const Volume& volume, const Cut& where, uint32_t channel, bool choose,
                           const bccsplat_render_options& options, const PictureSize& size,
                           const std::function<bccsplat_camera(const Slice&)>& camera) {
  const bccsplat_volume_info v = volume_info(volume);
  const bool merged = where.is_time_slice && where.method != BCCSPLAT_METHOD_EXTRACTED;
  Cut cut = where;
  if (choose && merged) cut.level = v.level_count;
  PictureCut out{cut_slice(volume, cut, channel), {}, {}, {}};
  out.camera = camera(out.slice), out.info = out.domain = slice_info(out.slice);
  if (!choose || !merged || v.level_count == 0) return out;
  auto needs = sized<bccsplat_picture_needs>();
  check(bccsplat_slice_get_picture_needs(out.slice.get(), &out.camera, size.width, size.height, &options,
                                         &needs),
        "picture");
  const bool simple = where.method == BCCSPLAT_METHOD_DEFAULT && where.lattice == BCCSPLAT_LATTICE_DEFAULT &&
                      where.spacing == 0;
  if (simple && !cut.region && needs.seen) cut.region = seen_region(needs, v);
  if (needs.level == cut.level && !cut.region) return out;
  cut.level = needs.level;
  const bccsplat_slice_info told = out.info;
  out.slice = cut_slice(volume, cut, channel), out.info = slice_info(out.slice);
  out.info.bytes_read += told.bytes_read, out.info.milliseconds += told.milliseconds;
  return out;
}

} // namespace bcc4
