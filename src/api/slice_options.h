// SPDX-License-Identifier: Apache-2.0
// The options of slices, between the C ABI and the core.
#pragma once

#include "bccsplat.h"

#include "volume/open_slice.h"

namespace bccsplat::api {

[[nodiscard]] HypersliceOptions read_slice_options(const bccsplat_slice_options& o, const OpenVolume& volume);
// The hyperplane of the call: in normal form, or spanned by the options' basis, whose axes go into `options`.
[[nodiscard]] Hyperplane read_hyperplane(const bccsplat_hyperplane* hyperplane,
                                         const bccsplat_slice_options& o, HypersliceOptions& options);

} // namespace bccsplat::api
