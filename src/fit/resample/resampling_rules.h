// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace bccsplat {

// Raised whenever the same source with the same options becomes other samples, air elsewhere,
// or slabs in another order: an import that another version began is then not resumed, and parts of different
// versions are not joined.
inline constexpr int resampling_rules = 8;

} // namespace bccsplat
