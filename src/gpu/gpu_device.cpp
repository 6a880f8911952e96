// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_device.h"

#include "gpu/gl_context.h"
#include "gpu/gpu_programs.h"

namespace bccsplat {

GpuDevice::GpuDevice(const GpuWishes& wishes) : wishes_(wishes) {}

GpuDevice::~GpuDevice() {
  if (worker_ && context_) worker_->run([this] { programs_.reset(), context_.reset(); });
}

void GpuDevice::open() {
  const std::scoped_lock lock(mutex_);
  if (failed_) throw GpuFailure(*failed_);
  if (context_) return;
  if (!worker_) worker_ = std::make_unique<Worker>();
  try {
    worker_->run([this] {
      context_ = std::make_unique<GlContext>(wishes_);
      programs_ = std::make_unique<GpuPrograms>(context_->info());
    });
  } catch (const GpuFailure& e) {
    failed_ = e.message();
    throw;
  }
}

const GpuInfo& GpuDevice::info() {
  open();
  return context_->info();
}

bool GpuDevice::preferred() {
  {
    const std::scoped_lock lock(mutex_);
    if (failed_) return false;
    if (!card_) card_ = any_graphics_card();
    if (!*card_) return false;
  }
  try {
    return !info().software;
  } catch (const GpuFailure&) {
    return false;
  }
}

void GpuDevice::run(const std::function<void()>& job) {
  open();
  worker_->run(job);
}

void GpuDevice::clear(const std::function<void()>& job) {
  if (context_) worker_->run(job);
}

void GpuDevice::give_up(const std::string& why) {
  const std::scoped_lock lock(mutex_);
  failed_ = why;
}

void GpuDevice::reserve(uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  const uint64_t limit = wishes_.memory_limit;
  if (limit > 0 && (bytes > limit || bytes_ > limit - bytes))
    fail_this_time("the picture's data need ", bytes, " bytes, the limit of ", limit, " has ",
                   bytes_ < limit ? limit - bytes_ : 0, " left; raise it");
  bytes_ += bytes;
}

void GpuDevice::release(uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  bytes_ -= bytes;
}

uint64_t GpuDevice::bytes() const {
  const std::scoped_lock lock(mutex_);
  return bytes_;
}

} // namespace bccsplat
