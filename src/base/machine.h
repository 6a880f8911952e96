// SPDX-License-Identifier: Apache-2.0
// What the machine has.
#pragma once

#include <cstdint>

namespace bccsplat {

// Bytes of memory; 1 GiB where the system does not tell.
[[nodiscard]] uint64_t machine_memory();

// Returns the number of this process, which a fork's child does not share.
[[nodiscard]] int64_t machine_process();

// Returns whether the system has a shared library of this name ("libEGL.so.1"), which then stays loaded.
// Libraries that the environment's BCCSPLAT_MISSING_LIBRARIES names, between colons, are taken for missing.
[[nodiscard]] bool machine_has_library(const char* name);

// Returns a function of the libraries that the process has loaded; null: there is none of this name.
[[nodiscard]] void* machine_symbol(const char* name);

// Has these called in the parent before each fork, and after it in the parent and the child; where there are
// none, never.
void around_forks(void (*before)(), void (*after)());

} // namespace bccsplat
