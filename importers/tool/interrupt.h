// SPDX-License-Identifier: Apache-2.0
// Ctrl-C and SIGTERM as a flag, and as a cancel token of the library's long calls.
#pragma once

#include "bccsplat.h"
#include "readers/error.h"

namespace bcc4 {

void catch_interrupts();
// Returns the token for the options of whatever may take long; null before catch_interrupts.
[[nodiscard]] bccsplat_cancel_token* interrupt_token();
[[nodiscard]] bool interrupted();
inline void stop_if_interrupted() {
  if (interrupted()) throw Error(Code::cancelled, "interrupted");
}

} // namespace bcc4
