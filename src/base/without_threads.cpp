// SPDX-License-Identifier: Apache-2.0
// Tasks and workers where a process has one thread, as in a browser: all is done by the caller.
#include "base/tasks.h"
#include "base/worker.h"

namespace bccsplat {

struct Tasks::Pool {};

Tasks::Tasks(int /*threads*/) : threads_(1) {}
Tasks::Tasks(HostRunner /*runner*/, int /*threads*/) : threads_(1) {}
Tasks::~Tasks() = default;

void Tasks::parallel_for(uint64_t count, const std::function<void(uint64_t)>& body) {
  for (uint64_t i = 0; i < count; ++i) body(i);
}

Worker::Worker() = default;
Worker::~Worker() = default;
void Worker::run(const std::function<void()>& job) { job(); }

} // namespace bccsplat
