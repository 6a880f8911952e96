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

Slice PictureCutter::slice_at(const Cut& cut, bccsplat_slice_info& info) {
  for (const Kept& k : kept_) {
    if (k.cut != cut) continue;
    bccsplat_slice_retain(k.slice.get());
    info = slice_info(k.slice), info.bytes_read = 0, info.milliseconds = 0;
    return Slice(k.slice.get());
  }
  constexpr size_t most = 2;
  if (kept_.size() == most) kept_.pop_back(); // before the next one takes memory
  Slice made = cut_slice(volume_, cut, channel_);
  info = slice_info(made);
  bccsplat_slice_retain(made.get());
  kept_.push_back({cut, Slice(made.get())});
  return made;
}

PictureCut PictureCutter::cut(const Cut& where, const std::function<bccsplat_camera(const Slice&)>& camera) {
  const bccsplat_volume_info v = volume_info(volume_);
  const bool merged =
      where.is_time_slice && where.method != BCCSPLAT_METHOD_EXTRACTED && where.bandwidth[0] == 0;
  Cut cut = where;
  if (choose_ && merged) cut.level = v.level_count;
  if (!kept_.empty() && kept_.front().cut != cut) kept_.clear();
  PictureCut out{};
  out.slice = slice_at(cut, out.info), out.domain = out.info, out.camera = camera(out.slice);
  if (!choose_ || !merged || v.level_count == 0) return out;
  auto needs = sized<bccsplat_picture_needs>();
  const bccsplat_view view = host_.view(out.camera);
  check(bccsplat_slice_get_view_needs(out.slice.get(), &view, host_.clips.data(), host_.clips.size(),
                                      size_.width, size_.height, &options_, &needs),
        "picture");
  const bool simple = where.method == BCCSPLAT_METHOD_DEFAULT && where.lattice == BCCSPLAT_LATTICE_DEFAULT &&
                      where.spacing == 0;
  // A box of uneven axes would be resampled for each camera.
  if (simple && !cut.region && needs.seen && !has_coordinates(volume_)) cut.region = seen_region(needs, v);
  if (needs.level == cut.level && !cut.region) return out;
  cut.level = needs.level;
  const bccsplat_slice_info told = out.info;
  out.slice = slice_at(cut, out.info);
  out.info.bytes_read += told.bytes_read, out.info.milliseconds += told.milliseconds;
  return out;
}

} // namespace bcc4
