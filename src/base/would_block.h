// SPDX-License-Identifier: Apache-2.0
// Bytes that are not there yet: what a source throws for them, and how a call hears of all that it lacks
// before it gives up.
#pragma once

#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

#include "base/byte_range.h"
#include "base/error.h"

namespace bccsplat {

// It passes whoever makes do with what cannot be read: these bytes can be, later.
class WouldBlock : public Error {
 public:
  WouldBlock(std::string message, std::vector<ByteRange> lacking)
      : Error(Code::would_block, std::move(message)), lacking_(std::move(lacking)) {}
  [[nodiscard]] const std::vector<ByteRange>& lacking() const { return lacking_; }

 private:
  std::vector<ByteRange> lacking_;
};

// Lets a call try several things, from several threads, and fail for all those together that have to wait.
class Attempts {
 public:
  // Returns false where the body ended with WouldBlock, which is kept; other exceptions pass.
  template<class Body> bool attempt(const Body& body) {
    try {
      body();
      return true;
    } catch (const WouldBlock& e) {
      add(e);
      return false;
    }
  }
  void add(const WouldBlock& e) {
    const std::scoped_lock lock(mutex_);
    if (lacking_.empty()) message_ = e.message();
    lacking_.insert(lacking_.end(), e.lacking().begin(), e.lacking().end());
    waits_.store(true, std::memory_order_relaxed);
  }
  [[nodiscard]] bool waits() const { return waits_.load(std::memory_order_relaxed); }
  void throw_if_waiting() {
    if (!waits()) return;
    const std::scoped_lock lock(mutex_);
    merge_ranges(lacking_, 0);
    throw WouldBlock(message_, lacking_);
  }

 private:
  std::mutex mutex_;
  std::string message_; // the first one's
  std::vector<ByteRange> lacking_;
  std::atomic<bool> waits_{false};
};

} // namespace bccsplat
