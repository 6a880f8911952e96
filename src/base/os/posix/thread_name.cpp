// SPDX-License-Identifier: Apache-2.0
#include "base/os/thread_name.h"

#include <pthread.h>

namespace bccsplat {

void name_this_thread(const char* name) {
#ifdef __APPLE__
  pthread_setname_np(name);
#else
  pthread_setname_np(pthread_self(), name);
#endif
}

} // namespace bccsplat
