// SPDX-License-Identifier: Apache-2.0
// Transfer functions made from what a channel's histogram says.
#pragma once

#include "shade/mode.h"
#include "shade/transfer_function.h"
#include "shade/value_survey.h"

namespace bccsplat {

enum class Look : uint8_t { automatic, ct_bone, ct_soft, mr, fog, fire, both_signs, labels };

// Returns what the look takes a channel's values for. Throws invalid_argument: labels of too many values.
[[nodiscard]] ValueSurvey survey_for(const ValueCounts& counts, Look look);

// Returns at most 64 points of colour and 32 of opacity, which is that of a mean voxel.
[[nodiscard]] TransferFunction look_function(const ValueSurvey& survey, Look look, RenderMode mode);

} // namespace bccsplat
