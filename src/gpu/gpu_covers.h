// SPDX-License-Identifier: Apache-2.0
// Which pictures the GPU leaves to the CPU.
#pragma once

#include "draw/shot.h"

namespace bccsplat {

// Why the GPU does not draw these; null: it does.
[[nodiscard]] const char* not_on_gpu(Shots shots);

} // namespace bccsplat
