// SPDX-License-Identifier: Apache-2.0
// A memory budget: bytes are reserved before they are allocated and given back when the reservation ends.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace bccsplat {

class MemoryBudget {
 public:
  explicit MemoryBudget(uint64_t limit_bytes = UINT64_MAX) : limit_(limit_bytes) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  [[nodiscard]] bool try_reserve(uint64_t bytes) noexcept {
    uint64_t used = used_.load(std::memory_order_relaxed);
    do {
      if (bytes > limit_ - used) return false;
    } while (!used_.compare_exchange_weak(used, used + bytes, std::memory_order_relaxed));
    uint64_t peak = peak_.load(std::memory_order_relaxed);
    while (used + bytes > peak &&
           !peak_.compare_exchange_weak(peak, used + bytes, std::memory_order_relaxed)) {
    }
    return true;
  }
  void release(uint64_t bytes) noexcept { used_.fetch_sub(bytes, std::memory_order_relaxed); }

  [[nodiscard]] uint64_t limit() const { return limit_; }
  [[nodiscard]] uint64_t used() const { return used_.load(std::memory_order_relaxed); }
  [[nodiscard]] uint64_t peak() const { return peak_.load(std::memory_order_relaxed); }

 private:
  uint64_t limit_;
  std::atomic<uint64_t> used_{0};
  std::atomic<uint64_t> peak_{0};
};

// Bytes held from a budget; movable, given back at the end of its life.
class Reservation {
 public:
  Reservation() = default;
  Reservation(MemoryBudget& budget, uint64_t bytes, std::string_view what) : budget_(&budget), bytes_(bytes) {
    if (!budget.try_reserve(bytes)) {
      budget_ = nullptr;
      fail(Code::memory_budget, what, " needs ", bytes, " bytes, the budget of ", budget.limit(), " has ",
           budget.limit() - budget.used(), " left; raise the memory budget");
    }
  }
  // Takes over bytes that try_reserve granted.
  static Reservation adopt(MemoryBudget& budget, uint64_t bytes) {
    Reservation r;
    r.budget_ = &budget;
    r.bytes_ = bytes;
    return r;
  }
  Reservation(Reservation&& other) noexcept
      : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
  Reservation& operator=(Reservation&& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~Reservation() {
    if (budget_) budget_->release(bytes_);
  }
  [[nodiscard]] uint64_t bytes() const { return bytes_; }
  // The bytes stay reserved; somebody else gives them back.
  void keep() noexcept { budget_ = nullptr; }

 private:
  MemoryBudget* budget_ = nullptr;
  uint64_t bytes_ = 0;
};

// Bytes that several threads add to, held from a budget until they are handed on together.
class SharedReservation {
 public:
  explicit SharedReservation(MemoryBudget& budget) : budget_(budget) {}
  SharedReservation(const SharedReservation&) = delete;
  SharedReservation& operator=(const SharedReservation&) = delete;
  ~SharedReservation() { budget_.release(bytes_.load(std::memory_order_relaxed)); }
  void add(uint64_t bytes, std::string_view what) {
    Reservation(budget_, bytes, what).keep();
    bytes_.fetch_add(bytes, std::memory_order_relaxed);
  }
  [[nodiscard]] Reservation take() {
    return Reservation::adopt(budget_, bytes_.exchange(0, std::memory_order_relaxed));
  }

 private:
  MemoryBudget& budget_;
  std::atomic<uint64_t> bytes_{0};
};

} // namespace bccsplat
