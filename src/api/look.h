// SPDX-License-Identifier: Apache-2.0
// What a volume says of a channel's values, for the transfer function that is made of it.
#pragma once

#include "api/handles.h"
#include "shade/look.h"

namespace bccsplat::api {

[[nodiscard]] ValueCounts value_counts(const bccsplat_volume& volume, uint32_t channel);

} // namespace bccsplat::api
