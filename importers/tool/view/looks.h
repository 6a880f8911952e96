// SPDX-License-Identifier: Apache-2.0
// The looks of --look by their names.
#pragma once

#include "bccsplat.h"
#include "tool/options.h"

namespace bcc4 {

[[nodiscard]] inline Choices<int32_t> look_names() {
  return {{"auto", BCCSPLAT_LOOK_DEFAULT},    {"ct-bone", BCCSPLAT_LOOK_CT_BONE},
          {"ct-soft", BCCSPLAT_LOOK_CT_SOFT}, {"mr", BCCSPLAT_LOOK_MR},
          {"fog", BCCSPLAT_LOOK_FOG},         {"fire", BCCSPLAT_LOOK_FIRE},
          {"signed", BCCSPLAT_LOOK_SIGNED},   {"labels", BCCSPLAT_LOOK_LABELS}};
}

} // namespace bcc4
