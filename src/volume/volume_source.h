// SPDX-License-Identifier: Apache-2.0
// The bytes behind a volume, read by no more calls at a time than the device allows.
#pragma once

#include <memory>
#include <semaphore>
#include <string>
#include <utility>

#include "base/files.h"
#include "base/progress.h"

namespace bccsplat {

class VolumeSource : public ByteSource {
 public:
  // turns: null where there is no limit. Until opened() every read looks first whether the call that opens
  // was cancelled.
  VolumeSource(std::shared_ptr<const ByteSource> bytes, std::shared_ptr<std::counting_semaphore<>> turns,
               const Progress& opening)
      : bytes_(std::move(bytes)), turns_(std::move(turns)), opening_(&opening) {}

  void opened() { opening_ = nullptr; }
  [[nodiscard]] uint64_t size() const override { return bytes_->size(); }
  [[nodiscard]] const std::string& name() const override { return bytes_->name(); }
  [[nodiscard]] uint64_t merge_gap() const override { return bytes_->merge_gap(); }
  void read_at(uint64_t offset, std::span<std::byte> out) const override {
    if (opening_) opening_->throw_if_cancelled();
    struct Turn {
      std::counting_semaphore<>* turns;
      explicit Turn(std::counting_semaphore<>* t) : turns(t) {
        if (turns) turns->acquire();
      }
      ~Turn() {
        if (turns) turns->release();
      }
      Turn(const Turn&) = delete;
      Turn& operator=(const Turn&) = delete;
    };
    const Turn turn(turns_.get());
    bytes_->read_at(offset, out);
  }

 private:
  std::shared_ptr<const ByteSource> bytes_; // that whoever opens the volume again reads, too
  std::shared_ptr<std::counting_semaphore<>> turns_;
  const Progress* opening_;
};

} // namespace bccsplat
