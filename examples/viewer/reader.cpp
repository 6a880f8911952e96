// SPDX-License-Identifier: Apache-2.0
#include "viewer/reader.h"

#include <utility>

namespace viewer {

Reader::Reader(std::function<void(const Wish&)> read, std::function<void()> told)
    : read_(std::move(read)), told_(std::move(told)), thread_([this] { run(); }) {}

Reader::~Reader() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool Reader::has(const Wish& wish) {
  {
    const std::scoped_lock lock(mutex_);
    if (there_ == wish) return true;
    asked_ = wish;
  }
  changed_.notify_all();
  return false;
}

void Reader::look_ahead(const Wish& wish) {
  {
    const std::scoped_lock lock(mutex_);
    ahead_ = wish;
  }
  changed_.notify_all();
}

void Reader::run() {
  for (;;) {
    std::optional<Wish> asked, wish;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stop_ || asked_ || ahead_; });
      if (stop_) return;
      asked = std::exchange(asked_, std::nullopt);
      wish = asked ? asked : std::exchange(ahead_, std::nullopt);
    }
    read_(*wish);
    if (!asked) continue;
    {
      const std::scoped_lock lock(mutex_);
      there_ = asked;
    }
    told_();
  }
}

} // namespace viewer
