// SPDX-License-Identifier: Apache-2.0
#include "tool/interrupt.h"

#include <csignal>

namespace bcc4 {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;

// A second signal ends the program at once.
void on_signal(int number) {
  g_interrupted = 1;
  std::signal(number, SIG_DFL);
}

} // namespace

void catch_interrupts() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGXFSZ, SIG_IGN); // writing past a limit on file sizes fails like a full disk
}

bool interrupted() { return g_interrupted != 0; }

} // namespace bcc4
