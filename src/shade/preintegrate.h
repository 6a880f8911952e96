// SPDX-License-Identifier: Apache-2.0
// Pre-integrated classification: the integrals of a transfer function, and when a picture needs them.
#pragma once

#include <cstdint>

#include "shade/transfer_function.h"

namespace bccsplat {

enum class Preintegrate : uint8_t { automatic, on, off };

// Returns the function's integrals over the table's values, empty where the table has one entry only.
// Extinctions are cut at 1e6 per unit distance: a shell of full opacity a thousandth of a step thick is
// opaque still.
[[nodiscard]] ValueIntegrals integrate_values(const TransferFunction& function, const ClassTable& table);

// Returns how far the picture of a segment of world length `path` is from that of its middle value, at most,
// where the value changes by `change` across it: premultiplied colour and opacity, relative to the function's
// largest. A ramp has change / 8 of its rise per value at its ends, a step 1/2, a peak narrower than the
// change up to 1, also where it lies between two entries of the table.
[[nodiscard]] double narrowness(const TransferFunction& function, const ClassTable& table, double change,
                                double path);
// Pre-integration pays from this narrowness on: ramps come to 0.004 to 0.07, a peak whose segments are 20 dB
// farther without it to 0.22 (tests/bench/notes/pre-integration.md).
inline constexpr double narrow_function = 0.15;

} // namespace bccsplat
