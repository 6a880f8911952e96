// SPDX-License-Identifier: Apache-2.0
// One thread that runs jobs one after the other: for what belongs to a thread, as a graphics context does.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace bccsplat {

class Worker {
 public:
  Worker();
  ~Worker(); // waits for the job under way
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Runs the job on the thread and returns when it has ended; what it throws is thrown here. Calls from
  // several threads wait for each other.
  void run(const std::function<void()>& job);

 private:
  void serve();

  std::mutex turns_; // of callers
  std::mutex mutex_; // of all below
  std::condition_variable changed_;
  const std::function<void()>* job_ = nullptr;
  std::exception_ptr thrown_;
  bool ends_ = false;
  std::thread thread_;
};

} // namespace bccsplat
