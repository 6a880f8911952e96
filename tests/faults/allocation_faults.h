// SPDX-License-Identifier: Apache-2.0
// The allocations of this program, counted and made to fail.
#pragma once

#include <cstdint>

namespace faults {

// From now on the allocation number `n` (from 0) of any thread fails, and with `all_after` those that follow.
void fail_allocation(uint64_t n, bool all_after);
// Allocations since then; they succeed again.
uint64_t stop_failing();
// Blocks that are allocated and not freed.
[[nodiscard]] int64_t live_allocations();

} // namespace faults
