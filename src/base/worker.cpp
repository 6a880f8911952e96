// SPDX-License-Identifier: Apache-2.0
#include "base/worker.h"

#include <utility>

#include "base/usual_floats.h"

namespace bccsplat {

Worker::Worker() : thread_([this] { serve(); }) {}

Worker::~Worker() {
  {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Worker::run(const std::function<void()>& job) {
  const std::scoped_lock turn(turns_);
  std::unique_lock lock(mutex_);
  job_ = &job;
  changed_.notify_all();
  changed_.wait(lock, [this] { return job_ == nullptr; });
  if (const std::exception_ptr thrown = std::exchange(thrown_, nullptr)) std::rethrow_exception(thrown);
}

void Worker::serve() {
  const UsualFloats floats;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ends_ || job_; });
    if (!job_) return;
    try {
      (*job_)();
    } catch (...) {
      thrown_ = std::current_exception();
    }
    job_ = nullptr;
    changed_.notify_all();
  }
}

} // namespace bccsplat
