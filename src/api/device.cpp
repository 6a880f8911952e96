// SPDX-License-Identifier: Apache-2.0
#include "api/handles.h"
#include "api/numbers.h"
#include "api/structs.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

// The C runner wrapped: the host calls body(task, index).
HostRunner wrap_runner(bccsplat_runner_fn runner, void* user) {
  return [runner, user](uint64_t count, const std::function<void(uint64_t)>& body) {
    const auto call = [](void* task, uint64_t index) {
      (*static_cast<const std::function<void(uint64_t)>*>(task))(index);
    };
    runner(user, count, call, const_cast<std::function<void(uint64_t)>*>(&body));
  };
}

} // namespace

bccsplat_device::bccsplat_device(const bccsplat_device_options& options)
    : tasks(options.runner ? std::make_unique<Tasks>(wrap_runner(options.runner, options.runner_user),
                                                     options.thread_count)
                           : std::make_unique<Tasks>(options.thread_count)),
      memory(options.memory_budget ? options.memory_budget : UINT64_MAX),
      max_sites(options.max_sites ? options.max_sites : uint64_t{1} << 42),
      backend(options.backend ? static_cast<Backend>(options.backend) : Backend::automatic),
      gpu(make_gpu({.software_too = true, .memory_limit = options.gpu_memory})),
      gpu_memory(options.gpu_memory), log_(options.log), log_user_(options.log_user) {
  if (options.max_reads > 0) read_turns = std::make_shared<std::counting_semaphore<>>(options.max_reads);
}

bool bccsplat_device::draws_by_gpu() const {
  return backend == Backend::gpu || (backend == Backend::automatic && prefers_gpu(gpu.get()));
}

void bccsplat_device::log(int32_t level, const std::string& message) {
  if (!log_) return;
  const std::scoped_lock lock(log_mutex_);
  log_(log_user_, level, message.c_str());
}

void bccsplat_device::hint(Hint which, const std::string& message) {
  const auto bit = static_cast<uint32_t>(which);
  if ((hinted_.fetch_or(bit) & bit) == 0) log(BCCSPLAT_LOG_WARNING, message);
}

void bccsplat_device::tell_gpu(const std::string& failed) {
  if (failed.empty()) return;
  {
    const std::scoped_lock lock(log_mutex_);
    if (failed == gpu_told_) return;
    gpu_told_ = failed;
  }
  log(BCCSPLAT_LOG_WARNING, concat("render: ", failed, "; the CPU draws"));
}

extern "C" {

bccsplat_status bccsplat_device_create(const bccsplat_device_options* options, bccsplat_device** device) {
  return guard([&] {
    require(device, "device");
    *device = nullptr;
    const auto o = read_struct(options, "bccsplat_device_options");
    require_range(o.thread_count, 0, most_threads, "bccsplat_device_options.thread_count");
    require_zero(o.reserved, "bccsplat_device_options.reserved");
    require_zero(o.reserved2, "bccsplat_device_options.reserved2");
    require_choice(o.backend, BCCSPLAT_BACKEND_GPU, "bccsplat_device_options.backend");
    *device = new bccsplat_device(o);
  });
}

void bccsplat_device_retain(bccsplat_device* device) { retain(device); }
void bccsplat_device_release(bccsplat_device* device) { release(device); }

bccsplat_status bccsplat_device_get_info(const bccsplat_device* device, bccsplat_device_info* info) {
  return guard([&] {
    require(device, "device");
    bccsplat_device_info out{};
    out.thread_count = device->tasks->threads();
    out.memory_budget = device->memory.limit();
    out.memory_used = device->memory.used();
    out.memory_peak = device->memory.peak();
    write_struct(info, out, "info");
  });
}

bccsplat_status bccsplat_device_get_gpu_info(bccsplat_device* device, bccsplat_gpu_info* info) {
  return guard([&] {
    require(device, "device");
    check_output(info, "info");
    const GpuInfo& found = gpu_info(device->gpu.get());
    bccsplat_gpu_info out{};
    out.software = found.software, out.compute = found.entry == GpuEntry::compute;
    out.memory = found.memory, out.memory_used = gpu_bytes(device->gpu.get());
    out.vendor = found.vendor.c_str(), out.renderer = found.renderer.c_str();
    out.version = found.version.c_str();
    write_struct(info, out, "info");
  });
}

} // extern "C"
