// SPDX-License-Identifier: Apache-2.0
// The type in which export gives the values of a channel back.
#pragma once

#include "bccsplat.h"
#include "readers/value_type.h"

namespace bcc4 {

// Integers go back as such, of 32 bits where nothing is missing and floats
// have all whole numbers of their range; the rest as f32.
[[nodiscard]] Type export_type(const bccsplat_channel_info& channel);
// Returns what is written for `value`.
[[nodiscard]] double exported_value(Type type, float value);

} // namespace bcc4
