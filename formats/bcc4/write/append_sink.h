// SPDX-License-Identifier: Apache-2.0
// Bytes that are appended to a file: they are held until there are enough of them, then written together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/files.h"
#include "formats/bcc4/layout.h"

namespace bccsplat {

class AppendSink {
 public:
  // position: where the first bytes go.
  AppendSink(std::unique_ptr<ByteSink> sink, uint64_t position)
      : sink_(std::move(sink)), position_(position) {}

  // Returns where the next bytes go, behind those that are held.
  [[nodiscard]] uint64_t position() const { return position_; }

  void append(std::span<const std::byte> bytes) {
    held_.insert(held_.end(), bytes.begin(), bytes.end());
    position_ += bytes.size();
    if (held_.size() >= write_bytes) write_held();
  }
  // Returns the block with the place that it got.
  [[nodiscard]] BlockRef append(const PackedBlock& block) {
    BlockRef ref = block.ref;
    ref.offset = position_;
    append(block.bytes);
    return ref;
  }
  // Goes on behind bytes that the file has already.
  void skip(uint64_t bytes) {
    write_held();
    position_ += bytes;
  }
  // Makes all that was appended survive a crash.
  void sync() {
    write_held();
    sink_->flush();
  }
  // Writes over bytes that are in the file, which survives a crash as well.
  void overwrite(uint64_t offset, std::span<const std::byte> bytes) {
    sink_->write_at(offset, bytes);
    sink_->flush();
  }
  // Ends the writing for good.
  void commit() { sink_->commit(); }

 private:
  static constexpr size_t write_bytes = 1u << 20;

  void write_held() {
    if (held_.empty()) return;
    sink_->write_at(position_ - held_.size(), held_);
    held_.clear();
  }

  std::unique_ptr<ByteSink> sink_;
  uint64_t position_;
  std::vector<std::byte> held_; // those before position_
};

} // namespace bccsplat
