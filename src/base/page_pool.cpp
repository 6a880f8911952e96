// SPDX-License-Identifier: Apache-2.0
// Pieces lie at multiples of their size, so that a block tells its own. Blocks are cut off a new piece one by
// one: none is touched before it is taken.
#include "base/page_pool.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <new>

#include "base/machine.h"

namespace bccsplat {
namespace {

constexpr size_t line = 64; // bytes

constexpr size_t in_lines(size_t bytes) { return (bytes + line - 1) / line * line; }

} // namespace

struct PagePool::Piece {
  struct FreeBlock {
    FreeBlock* next;
  };
  Piece *next = nullptr, *before = nullptr; // of those that are open
  FreeBlock* free = nullptr;                // those that have been given back
  size_t taken = 0, cut = 0;                // blocks

  static Piece* of(void* block) {
    const size_t in_piece = reinterpret_cast<uintptr_t>(block) % large_page;
    return reinterpret_cast<Piece*>(static_cast<std::byte*>(block) - in_piece);
  }
  [[nodiscard]] void* block(size_t i, size_t bytes) {
    return reinterpret_cast<std::byte*>(this) + in_lines(sizeof(Piece)) + i * bytes;
  }
};

PageStore::~PageStore() { close(); }

void PageStore::close() noexcept {
  const std::scoped_lock lock(mutex_);
  for (void* piece : empty_) give_back_large_page(piece);
  std::vector<void*>().swap(empty_);
  keeps_ = false;
}

void* PageStore::take() {
  void* piece = nullptr;
  if (empty_.empty()) {
    if (keeps_) empty_.reserve(taken_ + 1); // so that nothing can fail when pieces come back
    piece = take_large_page();
  } else {
    piece = empty_.back();
    empty_.pop_back();
  }
  ++taken_;
  return piece;
}

void PageStore::give_back(void* piece) noexcept {
  constexpr size_t share = 2, least = 2;
  --taken_;
  if (!keeps_) return give_back_large_page(piece);
  empty_.push_back(piece);
  for (; empty_.size() > std::max(least, taken_ / share); empty_.pop_back())
    give_back_large_page(empty_.back());
}

size_t PageStore::bytes() const {
  const std::scoped_lock lock(mutex_);
  return (taken_ + empty_.size()) * large_page;
}

PageStore& process_pages() {
  struct Process {
    alignas(PageStore) std::array<std::byte, sizeof(PageStore)> room;
    PageStore& store = *new (room.data()) PageStore; // nothing destroys it
    Process() {
      around_forks([] { process_pages().lock(); }, [] { process_pages().unlock(); });
    }
    ~Process() { store.close(); }
  };
  static Process process;
  return process.store;
}

PagePool::PagePool(size_t block, PageStore& store)
    : block_(in_lines(block)), blocks_((large_page - in_lines(sizeof(Piece))) / block_), store_(store) {}

void PagePool::link(Piece* piece) {
  piece->before = nullptr, piece->next = open_;
  if (open_) open_->before = piece;
  open_ = piece;
}

void PagePool::unlink(Piece* piece) {
  (piece->before ? piece->before->next : open_) = piece->next;
  if (piece->next) piece->next->before = piece->before;
}

void* PagePool::take() {
  const std::scoped_lock lock(store_.mutex_);
  if (!open_) link(new (store_.take()) Piece);
  Piece* const piece = open_;
  void* block = piece->free;
  if (block)
    piece->free = piece->free->next;
  else
    block = piece->block(piece->cut++, block_);
  if (++piece->taken == blocks_) unlink(piece);
  return block;
}

void PagePool::give_back(void* block) noexcept {
  const std::scoped_lock lock(store_.mutex_);
  Piece* const piece = Piece::of(block);
  piece->free = new (block) Piece::FreeBlock{piece->free};
  if (piece->taken-- == blocks_) link(piece);
  if (piece->taken > 0) return;
  unlink(piece);
  store_.give_back(piece);
}

} // namespace bccsplat
