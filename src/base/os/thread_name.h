// SPDX-License-Identifier: Apache-2.0
// Names of threads, as debuggers and profilers show them.
#pragma once

namespace bccsplat {

// Names the thread that calls, by at most 15 ASCII characters; without effect where threads have no names.
void name_this_thread(const char* name);

} // namespace bccsplat
