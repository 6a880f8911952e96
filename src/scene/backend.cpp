// SPDX-License-Identifier: Apache-2.0
#include "scene/backend.h"

#if BCCSPLAT_WITH_GPU
#include "gpu/gpu_device.h"
#endif

namespace bccsplat {

namespace {

[[noreturn]] void fail_without() {
  fail(Code::missing_feature, "gpu: the library was built without one; build it with BCCSPLAT_WITH_GPU");
}

} // namespace

#if BCCSPLAT_WITH_GPU
std::shared_ptr<GpuDevice> make_gpu(const GpuWishes& wishes) { return std::make_shared<GpuDevice>(wishes); }
const GpuInfo& gpu_info(GpuDevice* device) {
  if (!device) fail_without();
  return device->info();
}
bool prefers_gpu(GpuDevice* device) { return device && device->preferred(); }
void note_failure(GpuDevice* device, const GpuFailure& failure) {
  if (device && failure.for_good()) device->give_up(failure.message());
}
uint64_t gpu_bytes(const GpuDevice* device) { return device ? device->bytes() : 0; }
#else
std::shared_ptr<GpuDevice> make_gpu(const GpuWishes& /*wishes*/) { return nullptr; }
const GpuInfo& gpu_info(GpuDevice* /*device*/) { fail_without(); }
bool prefers_gpu(GpuDevice* /*device*/) { return false; }
void note_failure(GpuDevice* /*device*/, const GpuFailure& /*failure*/) {}
uint64_t gpu_bytes(const GpuDevice* /*device*/) { return 0; }
#endif

} // namespace bccsplat
