// SPDX-License-Identifier: Apache-2.0
#include "tool/interrupt.h"

#include <csignal>

namespace bcc4 {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;
bccsplat_cancel_token* g_token = nullptr; // made before there are signals; stays until the end

// A second signal ends the program at once.
void on_signal(int number) {
  g_interrupted = 1;
  if (g_token) (void)bccsplat_cancel_token_cancel(g_token);
  std::signal(number, SIG_DFL);
}

} // namespace

void catch_interrupts() {
  (void)bccsplat_cancel_token_create(&g_token); // without memory for it calls are waited for
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
#ifdef SIGXFSZ
  std::signal(SIGXFSZ, SIG_IGN); // writing past a limit on file sizes fails like a full disk
#endif
#ifdef SIGBREAK
  std::signal(SIGBREAK, on_signal); // Ctrl-Break of Windows
#endif
}

bccsplat_cancel_token* interrupt_token() { return g_token; }
bool interrupted() { return g_interrupted != 0; }

} // namespace bcc4
