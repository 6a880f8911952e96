// SPDX-License-Identifier: Apache-2.0
// Objects that tasks use one after the other, where each would be dear to make anew: memory of tiles, counts.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace bccsplat {

template<class T> class Pool {
 public:
  // Returns an object that was given back, else make(), a std::unique_ptr<T>. What a task does not give back
  // is gone.
  template<class Make> [[nodiscard]] std::unique_ptr<T> take(const Make& make) {
    {
      const std::scoped_lock lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<T> object = std::move(idle_.back());
        idle_.pop_back();
        return object;
      }
    }
    return make();
  }
  void give_back(std::unique_ptr<T> object) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(object));
  }
  // All that were given back; while nobody takes or gives any.
  [[nodiscard]] const std::vector<std::unique_ptr<T>>& idle() const { return idle_; }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_;
};

} // namespace bccsplat
