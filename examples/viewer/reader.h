// SPDX-License-Identifier: Apache-2.0
// Reads what moments need in a thread of its own, so that who draws them never waits for the disk.
#pragma once

#include "viewer/wish.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace viewer {

class Reader {
 public:
  // read: reads what a wish needs; told: is called, by the reading thread, when what has() asked for is
  // there.
  Reader(std::function<void(const Wish&)> read, std::function<void()> told);
  // Waits for the end of what is being read.
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  // Returns whether the wish's moment is there; if not, it is read next, and what was asked for before is
  // not.
  bool has(const Wish& wish);
  // Reads what a later wish is likely to need, unless something is asked for.
  void look_ahead(const Wish& wish);

 private:
  void run();

  std::function<void(const Wish&)> read_;
  std::function<void()> told_;
  std::mutex mutex_; // of all below
  std::condition_variable changed_;
  std::optional<Wish> there_, asked_, ahead_;
  bool stop_ = false;
  std::thread thread_;
};

} // namespace viewer
