// SPDX-License-Identifier: Apache-2.0
// A GPU with a context and a thread of its own, so that whatever context a host's threads have stays theirs;
// or the host's context, whose state is after a job as it was before.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "base/worker.h"
#include "gpu/gpu_info.h"

namespace bccsplat {

class GlContext;
class GpuPrograms; // gpu/gpu_programs.h

class GpuDevice {
 public:
  // Nothing is opened before the first call that needs it.
  explicit GpuDevice(const GpuWishes& wishes);
  ~GpuDevice();

  // Returns what was found; opens it. Throws GpuFailure, from then on the same one.
  [[nodiscard]] const GpuInfo& info();
  // Returns whether pictures are drawn by it where nobody asks for that: it is a card, and has not failed.
  [[nodiscard]] bool preferred();
  // Runs a job with the context current, opening it first. Throws GpuFailure, and what the job throws.
  void run(const std::function<void()>& job);
  // Runs a job that deletes what others made, whatever has failed since.
  void clear(const std::function<void()>& job);
  // The shaders that are compiled; of jobs.
  [[nodiscard]] GpuPrograms& programs() { return *programs_; }
  // No picture will be drawn by it any more.
  void give_up(const std::string& why);

  // Bytes on the GPU are reserved before they are made, and given back. Throws GpuFailure.
  void reserve(uint64_t bytes);
  [[nodiscard]] bool has_room(uint64_t bytes) const;
  void release(uint64_t bytes);
  [[nodiscard]] uint64_t bytes() const;

 private:
  void open();
  void open_host();
  [[nodiscard]] bool host_is_current() const;

  GpuWishes wishes_;
  mutable std::mutex mutex_; // of all below
  std::unique_ptr<Worker> worker_;
  std::unique_ptr<GlContext> context_;
  const void* host_context_ = nullptr; // in which jobs run where they are called
  std::unique_ptr<GpuPrograms> programs_;
  std::optional<std::string> failed_; // why
  std::optional<bool> card_;
  uint64_t bytes_ = 0;
};

} // namespace bccsplat
