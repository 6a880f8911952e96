// SPDX-License-Identifier: Apache-2.0
// Work that takes much memory, as many pieces at once as the budget has room for.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string_view>

#include "base/memory.h"

namespace bccsplat {

class MemoryTurns {
 public:
  explicit MemoryTurns(MemoryBudget& budget) : budget_(budget) {}

  // Runs work() with so many bytes reserved. Whoever finds no room waits for other threads to end theirs;
  // where nobody is at work it throws memory_budget.
  template<class Work> auto run(uint64_t bytes, std::string_view what, const Work& work) -> decltype(work()) {
    const Turn turn(*this, bytes, what);
    return work();
  }
  // Does the same, but one piece of work at a time goes on even without room.
  template<class Work> void run_one_beside(uint64_t bytes, const Work& work) {
    const Turn turn(*this, bytes, {});
    work();
  }

 private:
  class Turn {
   public:
    // what: for the error where there is no room; none: then it goes on without a reservation.
    Turn(MemoryTurns& turns, uint64_t bytes, std::optional<std::string_view> what) : turns_(turns) {
      std::unique_lock lock(turns.mutex_);
      bool granted = false;
      turns.ended_.wait(lock, [&] {
        granted = turns.budget_.try_reserve(bytes);
        return granted || turns.at_work_ == 0;
      });
      if (granted)
        held_ = Reservation::adopt(turns.budget_, bytes);
      else if (what)
        held_ = Reservation(turns.budget_, bytes, *what);
      ++turns.at_work_;
    }
    ~Turn() {
      {
        const std::scoped_lock lock(turns_.mutex_);
        held_ = {};
        --turns_.at_work_;
      }
      turns_.ended_.notify_all();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    MemoryTurns& turns_;
    Reservation held_;
  };

  MemoryBudget& budget_;
  std::mutex mutex_;
  std::condition_variable ended_;
  int at_work_ = 0;
};

} // namespace bccsplat
