// SPDX-License-Identifier: Apache-2.0
// A cache that drops the least recently used values when their weights exceed its capacity; safe to use from
// many threads.
#pragma once

#include <cstdint>
#include <iterator>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace bccsplat {

template<class Key, class Value> class LruCache {
 public:
  explicit LruCache(uint64_t capacity) : capacity_(capacity) {}

  [[nodiscard]] std::shared_ptr<const Value> find(const Key& key) {
    const std::scoped_lock lock(mutex_);
    const auto it = index_.find(key);
    if (it == index_.end()) return nullptr;
    order_.splice(order_.begin(), order_, it->second);
    return it->second->value;
  }

  // The same without making it the newest.
  [[nodiscard]] std::shared_ptr<const Value> look(const Key& key) {
    const std::scoped_lock lock(mutex_);
    const auto it = index_.find(key);
    return it == index_.end() ? nullptr : it->second->value;
  }
  [[nodiscard]] bool contains(const Key& key) { return look(key) != nullptr; }

  // Releases `hold` with the entry. A value that is already there stays.
  template<class Hold>
  void insert(const Key& key, std::shared_ptr<const Value> value, uint64_t weight, Hold hold) {
    const std::scoped_lock lock(mutex_);
    if (weight > capacity_ || index_.contains(key)) return;
    while (weight > capacity_ - used_) evict();
    order_.push_front({key, std::move(value), weight, std::make_shared<Hold>(std::move(hold))});
    index_[key] = order_.begin();
    used_ += weight;
  }

  // Shares what another cache holds, as far as it fits, the newest first: values, and what is held with them.
  // wanted(key): whether to.
  template<class Wanted> void take_over(LruCache& other, const Wanted& wanted) {
    const std::scoped_lock lock(mutex_, other.mutex_);
    for (const Entry& entry : other.order_) {
      if (entry.weight > capacity_ - used_ || index_.contains(entry.key) || !wanted(entry.key)) continue;
      order_.push_back(entry);
      index_[entry.key] = std::prev(order_.end());
      used_ += entry.weight;
    }
  }

  void drop(const Key& key) {
    const std::scoped_lock lock(mutex_);
    const auto it = index_.find(key);
    if (it == index_.end()) return;
    used_ -= it->second->weight;
    order_.erase(it->second);
    index_.erase(it);
  }

  // Drops the oldest entry; false when there is none.
  bool drop_oldest() {
    const std::scoped_lock lock(mutex_);
    if (order_.empty()) return false;
    evict();
    return true;
  }

 private:
  struct Entry {
    Key key;
    std::shared_ptr<const Value> value;
    uint64_t weight;
    std::shared_ptr<void> hold;
  };
  void evict() {
    used_ -= order_.back().weight;
    index_.erase(order_.back().key);
    order_.pop_back();
  }

  uint64_t capacity_, used_ = 0;
  std::mutex mutex_;
  std::list<Entry> order_; // newest first
  std::map<Key, typename std::list<Entry>::iterator> index_;
};

} // namespace bccsplat
