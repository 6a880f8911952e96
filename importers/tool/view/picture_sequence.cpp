// SPDX-License-Identifier: Apache-2.0
#include "tool/view/picture_sequence.h"

#include <algorithm>
#include <cmath>

#include "readers/sequence.h"
#include "tool/view/contact_sheet.h"
#include "tool/view/slice_sweep.h"

namespace bcc4 {
namespace {

// As many as the film lasts, from the first frame to the last; of a whole turn of a periodic series, whose
// end is its first frame again, that end is left out.
std::vector<Picture> evenly(const Volume& volume, const RenderArguments& a) {
  const size_t count = *pictures_of_film(a);
  const bool turn = volume_info(volume).time_periodic && a.frames->first == 0 &&
                    a.frames->last == last_index(volume_info(volume));
  const double step = (a.frames->last - a.frames->first) / static_cast<double>(turn ? count : count - 1);
  std::vector<Picture> out;
  for (size_t i = 0; i < count; ++i) {
    const double frame = std::min(a.frames->last, a.frames->first + static_cast<double>(i) * step);
    out.push_back({cut_at_index(volume, frame), 0, 0, {}});
    set_shape(out.back().where, a.which);
  }
  return out;
}

std::vector<Picture> pictures_of_frames(const Volume& volume, const RenderArguments& a) {
  if (a.which.time || a.which.index || a.which.plane || a.which.point)
    fail_usage("--frames excludes --time, --plane and --point");
  const double last_frame = last_index(volume_info(volume));
  if (!(a.frames->first >= 0 && a.frames->last <= last_frame))
    fail_usage("--frames: the frames are 0 to ", last_frame);
  std::vector<Picture> out;
  if (a.seconds) return evenly(volume, a);
  const auto count = static_cast<size_t>((a.frames->last - a.frames->first) / a.frames->step + 1e-9) + 1;
  if (count > 1'000'000) fail_usage("--frames: ", count, " pictures are too many");
  for (size_t i = 0; i < count; ++i) {
    const double frame = std::min(a.frames->last, a.frames->first + static_cast<double>(i) * a.frames->step);
    out.push_back({cut_at_index(volume, frame), 0, 0, {}});
    set_shape(out.back().where, a.which);
  }
  return out;
}

} // namespace

std::vector<Picture> picture_sequence(const Volume& volume, const RenderArguments& a, size_t cameras) {
  std::vector<Picture> pictures;
  if (a.frames)
    pictures = pictures_of_frames(volume, a);
  else
    for (const Cut& where : sweep(volume, a.which)) pictures.push_back({where, 0, 0, {}});
  const size_t views = a.turntable ? static_cast<size_t>(*a.turntable) : cameras;
  if (!a.frames && pictures.size() == 1 && views > 1) pictures.assign(views, Picture(pictures.front()));
  if (a.turntable)
    for (size_t i = 0; i < pictures.size(); ++i)
      pictures[i].turn = 360.0 * static_cast<double>(i % views) / static_cast<double>(views);
  if (cameras > 1) {
    if (pictures.size() != cameras)
      fail_usage("--camera: it has ", cameras, " frames for ", pictures.size(), " pictures");
    for (size_t i = 0; i < pictures.size(); ++i) pictures[i].camera = i;
  }

  for (Picture& p : pictures) p.where.even = has_coordinates(volume);
  if (a.sheet) {
    std::vector<Picture> chosen;
    for (const size_t i :
         places_on_sheet(pictures.size(), size_t{(*a.sheet)[0]} * (*a.sheet)[1], a.turntable && !a.frames))
      chosen.push_back(pictures[i]);
    pictures = std::move(chosen);
  }

  // Numbered by frame where frames are whole, else by their order.
  const bool several = a.frames || a.which.sweep || a.turntable || pictures.size() > 1;
  const bool together = makes_one_file(a);
  if (together && has_frame_pattern(a.output))
    fail_usage("-o ", a.output, ": a ", a.sheet ? "sheet" : "film",
               " is one file; its name needs no pattern");
  if (pictures.size() > 1 && !together && !has_frame_pattern(a.output))
    fail_usage("-o ", a.output, ": ", pictures.size(), " pictures need a pattern such as smoke.%04d.png");
  const bool by_frame = a.frames && std::all_of(pictures.begin(), pictures.end(), [](const Picture& p) {
                          return p.where.index == std::floor(p.where.index);
                        });
  for (size_t i = 0; i < pictures.size(); ++i)
    pictures[i].path = several && !together
                           ? apply_frame_pattern(a.output, by_frame ? std::llround(pictures[i].where.index)
                                                                    : static_cast<int64_t>(i))
                           : a.output;
  return pictures;
}

} // namespace bcc4
