// SPDX-License-Identifier: Apache-2.0
// Ctrl-C and SIGTERM as a flag.
#pragma once

#include "readers/error.h"

namespace bcc4 {

void catch_interrupts();
[[nodiscard]] bool interrupted();
inline void stop_if_interrupted() {
  if (interrupted()) fail(Exit::interrupted, "interrupted");
}

} // namespace bcc4
