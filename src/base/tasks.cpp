// SPDX-License-Identifier: Apache-2.0
// The pool of threads behind parallel_for: its workers help with the newest job that has indices left, and
// the caller works, too.
#include "base/tasks.h"

#include <algorithm>
#include <atomic>
#include <new>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/os/thread_name.h"
#include "base/usual_floats.h"

namespace bccsplat {
namespace {

thread_local bool inside_parallel_for = false;

} // namespace

struct Tasks::Pool {
  // One parallel_for under way; shared by the caller and the workers that help.
  struct Job {
    Job(uint64_t n, const std::function<void(uint64_t)>& b) : count(n), body(b) {}
    uint64_t count;
    const std::function<void(uint64_t)>& body;
    std::atomic<uint64_t> next{0};
    std::atomic<bool> failed{false};
    std::mutex mutex;
    std::exception_ptr error;
    int helpers = 0; // workers inside; guarded by the pool's mutex

    [[nodiscard]] bool drained() const {
      return failed.load(std::memory_order_relaxed) || next.load(std::memory_order_relaxed) >= count;
    }

    void run() {
      const bool outer = std::exchange(inside_parallel_for, true);
      while (!failed.load(std::memory_order_relaxed)) {
        const uint64_t index = next.fetch_add(1, std::memory_order_relaxed);
        if (index >= count) break;
        run_one(index);
      }
      inside_parallel_for = outer;
    }

    void run_one(uint64_t index) {
      try {
        body(index);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!error) error = std::current_exception();
        failed.store(true, std::memory_order_relaxed);
      }
    }
  };

  std::mutex mutex;
  std::condition_variable wake, idle;
  std::vector<Job*> jobs; // under way, newest last
  bool stop = false;
  std::vector<std::thread> workers;

  explicit Pool(int count) {
    workers.reserve(count);
    try {
      for (int i = 0; i < count; ++i) workers.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      // The system gives no more threads, so those there are, and the caller, do the work.
    } catch (const std::bad_alloc&) {
      // As above.
    }
  }
  ~Pool() {
    {
      const std::scoped_lock lock(mutex);
      stop = true;
    }
    wake.notify_all();
    for (auto& worker : workers) worker.join();
  }

  // Returns the newest job with indices left; the mutex must be held.
  Job* open_job() {
    for (auto it = jobs.rbegin(); it != jobs.rend(); ++it)
      if (!(*it)->drained()) return *it;
    return nullptr;
  }

  void work() {
    const UsualFloats floats; // a thread begins with those of the one that started it
    name_this_thread("bccsplat");
    std::unique_lock lock(mutex);
    for (;;) {
      Job* job = nullptr;
      wake.wait(lock, [&] { return stop || (job = open_job()) != nullptr; });
      if (stop) return;
      ++job->helpers;
      lock.unlock();
      job->run();
      lock.lock();
      if (--job->helpers == 0) idle.notify_all();
    }
  }

  void run(Job& job) {
    {
      const std::scoped_lock lock(mutex);
      jobs.push_back(&job);
    }
    wake.notify_all();
    job.run();
    std::unique_lock lock(mutex);
    idle.wait(lock, [&] { return job.helpers == 0; });
    std::erase(jobs, &job);
  }
};

Tasks::Tasks(int threads)
    : threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))) {}

Tasks::Tasks(HostRunner runner, int threads) : threads_(std::max(threads, 1)), runner_(std::move(runner)) {}

Tasks::~Tasks() = default;

void Tasks::parallel_for(uint64_t count, const std::function<void(uint64_t)>& body) {
  if (count == 0) return;
  if (threads_ == 1 || count == 1 || inside_parallel_for) {
    for (uint64_t i = 0; i < count; ++i) body(i);
    return;
  }
  Pool::Job job(count, body);
  if (runner_) {
    std::atomic<uint64_t> ran{0};
    runner_(count, [&job, &ran](uint64_t index) {
      ran.fetch_add(1, std::memory_order_relaxed);
      if (job.failed.load(std::memory_order_relaxed)) return;
      const UsualFloats floats;
      const bool outer = std::exchange(inside_parallel_for, true);
      job.run_one(index);
      inside_parallel_for = outer;
    });
    if (ran != count && !job.error)
      fail(Code::wrong_state, "device: the runner ran ", ran.load(), " of ", count,
           " bodies before it returned");
  } else {
    {
      const std::scoped_lock lock(start_);
      if (!pool_) pool_ = std::make_unique<Pool>(threads_ - 1);
    }
    pool_->run(job);
  }
  if (job.error) std::rethrow_exception(job.error);
}

} // namespace bccsplat
