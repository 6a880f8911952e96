// SPDX-License-Identifier: Apache-2.0
// What the machine has.
#pragma once

#include <cstdint>

namespace bccsplat {

// Bytes of memory; 1 GiB where the system does not tell.
[[nodiscard]] uint64_t machine_memory();

} // namespace bccsplat
