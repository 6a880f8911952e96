// SPDX-License-Identifier: Apache-2.0
// What an import would cost, before it is made.
#pragma once

#include "readers/frame_reader.h"
#include "tool/import/plan.h"

namespace bcc4 {

// Sends the middle frames of the series through the real writer, into nothing, and extrapolates.
[[nodiscard]] ImportEstimate estimate_import(FrameReader& reader, const Device& device,
                                             const ImportPlan& plan);

} // namespace bcc4
