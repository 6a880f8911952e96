// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/world_names.h"

#include "tool/view/picture_shape.h"

namespace bcc4 {

std::optional<WorldNames> world_names(const Volume& volume) {
  bccsplat_side side = BCCSPLAT_SIDE_FRONT;
  check(bccsplat_volume_get_side(volume.get(), &side), "");
  if (side == BCCSPLAT_SIDE_ANTERIOR_RAS) return WorldNames{{{"L", "R"}, {"P", "A"}, {"I", "S"}}};
  if (side == BCCSPLAT_SIDE_ANTERIOR_LPS) return WorldNames{{{"R", "L"}, {"A", "P"}, {"I", "S"}}};
  const std::string degrees = "degrees", unit = volume_info(volume).spatial_unit;
  const auto units = different_units(volume);
  if (unit == degrees || (units && (*units)[0] == degrees && (*units)[1] == degrees))
    return WorldNames{{{"W", "E"}, {"S", "N"}, {"", ""}}};
  return std::nullopt;
}

} // namespace bcc4
