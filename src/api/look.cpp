// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/structs.h"
#include "scene/default_look.h"
#include "volume/first_picture.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

void write_look(const ValueSurvey& survey, const FirstPicture& first, Look wanted, int32_t mode,
                bccsplat_look* out) {
  const TransferFunction f = look_function(
      survey, wanted, mode == BCCSPLAT_MODE_DEFAULT ? RenderMode::composite : static_cast<RenderMode>(mode));
  bccsplat_look made{};
  made.kind = static_cast<int32_t>(survey.kind);
  made.empty[0] = survey.empty.low, made.empty[1] = survey.empty.high;
  made.range[0] = survey.colors.low, made.range[1] = survey.colors.high;
  made.iso_value = survey.surface;
  made.color_count = static_cast<uint32_t>(std::min(f.colors.size(), std::size(made.colors)));
  made.opacity_count = static_cast<uint32_t>(std::min(f.opacities.size(), std::size(made.opacities)));
  for (uint32_t i = 0; i < made.color_count; ++i) {
    made.colors[i][0] = f.colors[i].value;
    for (size_t a = 0; a < 3; ++a) made.colors[i][a + 1] = f.colors[i].color[a];
  }
  for (uint32_t i = 0; i < made.opacity_count; ++i)
    made.opacities[i][0] = f.opacities[i].value, made.opacities[i][1] = f.opacities[i].opacity;
  made.layout = static_cast<int32_t>(first.layout), made.frame = first.frame;
  write_struct(out, made, "out");
}

void require_look(int32_t look, int32_t mode) {
  require_choice(look, BCCSPLAT_LOOK_LABELS, "look"), require_choice(mode, BCCSPLAT_MODE_MAXIMUM, "mode");
}

} // namespace

bccsplat_status bccsplat_volume_get_look(const bccsplat_volume* volume, uint32_t channel, int32_t look,
                                         int32_t mode, bccsplat_look* out) {
  return guard([&] {
    require(volume, "volume");
    require_look(look, mode);
    const auto wanted = static_cast<Look>(look);
    const ValueCounts counts = value_counts(volume->file, channel);
    write_look(survey_for(counts, wanted), first_picture(volume->file, channel, counts.data), wanted, mode,
               out);
  });
}

bccsplat_status bccsplat_slice_get_look(const bccsplat_slice* slice, int32_t look, int32_t mode,
                                        bccsplat_look* out) {
  return guard([&] {
    require(slice, "slice");
    require_look(look, mode);
    if (slice->open.slice.empty()) fail(Code::wrong_state, "slice: it misses the volume, and has no values");
    const auto wanted = static_cast<Look>(look);
    const OpenVolume& file = slice->volume->file;
    const ValueSurvey survey = survey_of_slice(file, slice->open, wanted);
    write_look(survey, first_picture(file, slice->open.channel, survey.data), wanted, mode, out);
  });
}
