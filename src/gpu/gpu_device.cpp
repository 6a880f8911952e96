// SPDX-License-Identifier: Apache-2.0
// Opens a GPU when it is first needed, on a thread of its own, and remembers what fails for good.
#include "gpu/gpu_device.h"

#include <algorithm>
#include <atomic>

#include "base/machine.h"
#include "gpu/gl_context.h"
#include "gpu/gl_state.h"
#include "gpu/gpu_programs.h"

namespace bccsplat {

namespace {

// The process that first opened a GPU; 0: none has. A fork's child has no threads of its driver.
std::atomic<int64_t> opened_by{0};

bool forked_since() {
  const int64_t by = opened_by.load();
  return by != 0 && by != machine_process();
}

void note_process() {
  if (forked_since())
    fail_gpu(
        "the process was forked from one that had opened a GPU, whose driver does not survive that; fork "
        "before, or let the CPU draw");
  opened_by.store(machine_process());
}

} // namespace

GpuDevice::GpuDevice(const GpuWishes& wishes) : wishes_(wishes) {
  if (only_host_contexts) wishes_.host_context = true;
}

GpuDevice::~GpuDevice() {
  if (forked_since()) { // its thread is not here, and what it has is the parent's
    (void)worker_.release(), (void)context_.release(), (void)programs_.release();
    return;
  }
  if (host_context_) clear([this] { programs_.reset(); });
  if (worker_ && context_) worker_->run([this] { programs_.reset(), context_.reset(); });
}

void GpuDevice::open_host() {
  const void* const current = current_gl_context();
  if (!current) fail_gpu("no OpenGL context is current on this thread; make the host's current");
  if (host_context_ && current != host_context_)
    fail_gpu("another OpenGL context is current than the one that the frame was first drawn in");
  if (programs_) return;
  programs_ = std::make_unique<GpuPrograms>(current_context_info(wishes_.entry));
  host_context_ = current;
}

bool GpuDevice::host_is_current() const { return host_context_ == current_gl_context(); }

void GpuDevice::open() {
  const std::scoped_lock lock(mutex_);
  if (wishes_.host_context) return open_host();
  note_process();
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
  return programs_->info();
}

bool GpuDevice::preferred() {
  {
    const std::scoped_lock lock(mutex_);
    if (failed_ || forked_since()) return false;
    if (!card_) card_ = wishes_.as_card || any_graphics_card();
    if (!*card_) return false;
  }
  try {
    return !info().software || wishes_.as_card;
  } catch (const GpuFailure&) {
    return false;
  }
}

void GpuDevice::run(const std::function<void()>& job) {
  open();
  if (only_host_contexts) return job(); // a browser takes longer to tell a state than to draw a picture
  if (wishes_.host_context) {
    const GlState as_it_was;
    return job();
  }
  worker_->run(job);
}

void GpuDevice::clear(const std::function<void()>& job) {
  if (wishes_.host_context) {
    gl_objects_gone = !host_context_ || !host_is_current();
    job();
    gl_objects_gone = false;
    return;
  }
  gl_objects_gone = forked_since();
  if (gl_objects_gone) job();
  gl_objects_gone = false;
  if (context_ && !forked_since()) worker_->run(job);
}

void GpuDevice::give_up(const std::string& why) {
  const std::scoped_lock lock(mutex_);
  failed_ = why;
}

void GpuDevice::reserve(uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  const uint64_t limit = wishes_.memory_limit > 0 ? wishes_.memory_limit : UINT64_MAX;
  const uint64_t left = limit - std::min(bytes_, limit);
  if (bytes > left)
    fail_this_time("the slice takes ", bytes, " bytes, the limit of ", limit, " has ", left,
                   " left; raise it, or let the CPU draw");
  bytes_ += bytes;
}

bool GpuDevice::has_room(uint64_t bytes) const {
  const std::scoped_lock lock(mutex_);
  const uint64_t limit = wishes_.memory_limit > 0 ? wishes_.memory_limit : UINT64_MAX;
  return bytes <= limit - std::min(bytes_, limit);
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
