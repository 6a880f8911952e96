// SPDX-License-Identifier: Apache-2.0
// Gathers the small pieces that libraries of images write, and keeps what a sink throws where a library would
// swallow it.
#pragma once

#include <cstdint>
#include <exception>
#include <span>
#include <vector>

#include "base/files.h"

namespace bccsplat {

class SinkBuffer {
 public:
  explicit SinkBuffer(ByteSink& sink) : sink_(sink) {}

  void write(uint64_t offset, std::span<const std::byte> bytes) {
    if (offset != first_ + pending_.size()) spill(), first_ = offset;
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
    if (pending_.size() >= most_pending) spill();
  }
  // Writes what is pending; throws, too, what the sink threw at any time before.
  void finish() {
    if (error_) std::rethrow_exception(error_);
    spill();
  }

 private:
  static constexpr size_t most_pending = 64 << 10;

  void spill() {
    if (error_) return; // the rest is of no use
    try {
      if (!pending_.empty()) sink_.write_at(first_, pending_);
    } catch (...) {
      error_ = std::current_exception();
      throw;
    }
    first_ += pending_.size();
    pending_.clear();
  }

  ByteSink& sink_;
  uint64_t first_ = 0; // of what is pending
  std::vector<std::byte> pending_;
  std::exception_ptr error_;
};

} // namespace bccsplat
