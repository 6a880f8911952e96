// SPDX-License-Identifier: Apache-2.0
// Parallel-for over indices: a small pool of our own, or the host's runner.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace bccsplat {

// Runs body(index) for index in [0, count), on any threads, and returns when all are done.
using HostRunner = std::function<void(uint64_t count, const std::function<void(uint64_t index)>& body)>;

class Tasks {
 public:
  // 0 threads are as many as the machine has. Threads start at the first parallel call and are joined by the
  // destructor.
  explicit Tasks(int threads = 0);
  // Every parallel call goes through `runner`; `threads` tells how many it uses.
  Tasks(HostRunner runner, int threads);
  ~Tasks();
  Tasks(const Tasks&) = delete;
  Tasks& operator=(const Tasks&) = delete;

  [[nodiscard]] int threads() const { return threads_; }

  // Calls body(index) once for each index in [0, count); order and thread are free. The first exception is
  // rethrown after all started bodies ended; further indices are then not started. Nested calls run in the
  // calling thread.
  void parallel_for(uint64_t count, const std::function<void(uint64_t index)>& body);

 private:
  struct Pool;
  int threads_;
  HostRunner runner_;
  std::unique_ptr<Pool> pool_;
  std::mutex start_;
};

} // namespace bccsplat
