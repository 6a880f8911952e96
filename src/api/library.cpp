// SPDX-License-Identifier: Apache-2.0
// What the library says of itself, the names of statuses and kernels, and what each thread heard last.
#include <algorithm>
#include <array>
#include <cstring>

#include "api/guard.h"

namespace bccsplat::api {
namespace {

thread_local std::array<char, 1024> last_error{};
// Plain numbers, which need no destructor when the library is unloaded.
struct Lacking {
  std::array<uint64_t, 512> pairs; // offset and size
  uint64_t count;
};
thread_local Lacking last_lacking{};

struct Name {
  bccsplat_status status;
  const char* name;
};
constexpr Name status_names[] = {
    {BCCSPLAT_OK, "BCCSPLAT_OK"},
    {BCCSPLAT_ERROR_INVALID_ARGUMENT, "BCCSPLAT_ERROR_INVALID_ARGUMENT"},
    {BCCSPLAT_ERROR_INVALID_STRUCT_SIZE, "BCCSPLAT_ERROR_INVALID_STRUCT_SIZE"},
    {BCCSPLAT_ERROR_INVALID_HANDLE, "BCCSPLAT_ERROR_INVALID_HANDLE"},
    {BCCSPLAT_ERROR_WRONG_STATE, "BCCSPLAT_ERROR_WRONG_STATE"},
    {BCCSPLAT_ERROR_OUT_OF_DOMAIN, "BCCSPLAT_ERROR_OUT_OF_DOMAIN"},
    {BCCSPLAT_ERROR_UNSUPPORTED, "BCCSPLAT_ERROR_UNSUPPORTED"},
    {BCCSPLAT_ERROR_NOT_FOUND, "BCCSPLAT_ERROR_NOT_FOUND"},
    {BCCSPLAT_ERROR_NOT_BCC4, "BCCSPLAT_ERROR_NOT_BCC4"},
    {BCCSPLAT_ERROR_UNSUPPORTED_VERSION, "BCCSPLAT_ERROR_UNSUPPORTED_VERSION"},
    {BCCSPLAT_ERROR_CORRUPT, "BCCSPLAT_ERROR_CORRUPT"},
    {BCCSPLAT_ERROR_TRUNCATED, "BCCSPLAT_ERROR_TRUNCATED"},
    {BCCSPLAT_ERROR_CHECKSUM_MISMATCH, "BCCSPLAT_ERROR_CHECKSUM_MISMATCH"},
    {BCCSPLAT_ERROR_LIMIT_EXCEEDED, "BCCSPLAT_ERROR_LIMIT_EXCEEDED"},
    {BCCSPLAT_ERROR_NONFINITE_VALUE, "BCCSPLAT_ERROR_NONFINITE_VALUE"},
    {BCCSPLAT_ERROR_BOUND_NOT_MET, "BCCSPLAT_ERROR_BOUND_NOT_MET"},
    {BCCSPLAT_ERROR_HOLE, "BCCSPLAT_ERROR_HOLE"},
    {BCCSPLAT_ERROR_OUT_OF_MEMORY, "BCCSPLAT_ERROR_OUT_OF_MEMORY"},
    {BCCSPLAT_ERROR_IO, "BCCSPLAT_ERROR_IO"},
    {BCCSPLAT_ERROR_FILE_NOT_FOUND, "BCCSPLAT_ERROR_FILE_NOT_FOUND"},
    {BCCSPLAT_ERROR_NO_SPACE, "BCCSPLAT_ERROR_NO_SPACE"},
    {BCCSPLAT_ERROR_PERMISSION_DENIED, "BCCSPLAT_ERROR_PERMISSION_DENIED"},
    {BCCSPLAT_ERROR_FILE_EXISTS, "BCCSPLAT_ERROR_FILE_EXISTS"},
    {BCCSPLAT_ERROR_MEMORY_BUDGET, "BCCSPLAT_ERROR_MEMORY_BUDGET"},
    {BCCSPLAT_ERROR_MISSING_FEATURE, "BCCSPLAT_ERROR_MISSING_FEATURE"},
    {BCCSPLAT_ERROR_WOULD_BLOCK, "BCCSPLAT_ERROR_WOULD_BLOCK"},
    {BCCSPLAT_CANCELLED, "BCCSPLAT_CANCELLED"},
    {BCCSPLAT_ERROR_INTERNAL, "BCCSPLAT_ERROR_INTERNAL"},
};

// The core's codes are the ABI's.
static_assert(static_cast<int32_t>(Code::unsupported) == BCCSPLAT_ERROR_UNSUPPORTED);
static_assert(static_cast<int32_t>(Code::not_found) == BCCSPLAT_ERROR_NOT_FOUND);
static_assert(static_cast<int32_t>(Code::out_of_domain) == BCCSPLAT_ERROR_OUT_OF_DOMAIN);
static_assert(static_cast<int32_t>(Code::not_bcc4) == BCCSPLAT_ERROR_NOT_BCC4);
static_assert(static_cast<int32_t>(Code::hole) == BCCSPLAT_ERROR_HOLE);
static_assert(static_cast<int32_t>(Code::out_of_memory) == BCCSPLAT_ERROR_OUT_OF_MEMORY);
static_assert(static_cast<int32_t>(Code::missing_feature) == BCCSPLAT_ERROR_MISSING_FEATURE);
static_assert(static_cast<int32_t>(Code::would_block) == BCCSPLAT_ERROR_WOULD_BLOCK);
static_assert(static_cast<int32_t>(Code::cancelled) == BCCSPLAT_CANCELLED);
static_assert(static_cast<int32_t>(Code::internal) == BCCSPLAT_ERROR_INTERNAL);

// kernel_names() order; the strings live as long as the library.
constexpr const char* kernels[] = {"default",     "exact",       "fast",        "fine",        "gauss09",
                                   "paper",       "radial16+b2", "radial16+b3", "radial16+b4", "radial18+b2",
                                   "radial18+b3", "radial18+b4", "radial20+b2", "radial20+b3", "radial20+b4",
                                   "radial24+b2", "radial24+b3", "radial24+b4"};

} // namespace

void set_last_error(std::string_view text) noexcept {
  const size_t n = std::min(text.size(), last_error.size() - 1);
  std::memcpy(last_error.data(), text.data(), n);
  last_error[n] = 0;
}

void set_last_lacking(std::span<const ByteRange> ranges) noexcept {
  last_lacking.count = 0;
  try {
    std::vector<ByteRange> merged(ranges.begin(), ranges.end());
    merge_ranges(merged, 0);
    for (const ByteRange& r : merged) {
      const uint64_t n = last_lacking.count;
      if (2 * n == last_lacking.pairs.size()) break;
      last_lacking.pairs[2 * n] = r.offset, last_lacking.pairs[2 * n + 1] = r.size;
      ++last_lacking.count;
    }
  } catch (const std::bad_alloc&) {
    // The host makes the call again and hears of none in advance.
  }
}

} // namespace bccsplat::api

// Outside the namespace: inside it these would be other functions than those the header exports.
using namespace bccsplat::api;

extern "C" {

int32_t bccsplat_version(void) {
  return BCCSPLAT_VERSION_MAJOR * 10000 + BCCSPLAT_VERSION_MINOR * 100 + BCCSPLAT_VERSION_PATCH;
}

int32_t bccsplat_abi_version(void) { return BCCSPLAT_ABI_VERSION; }

#define BCCSPLAT_TEXT_OF(x) #x
#define BCCSPLAT_TEXT(x) BCCSPLAT_TEXT_OF(x)
const char* bccsplat_build_info(void) {
  return "version=" BCCSPLAT_TEXT(BCCSPLAT_VERSION_MAJOR) "." BCCSPLAT_TEXT(
      BCCSPLAT_VERSION_MINOR) "." BCCSPLAT_TEXT(BCCSPLAT_VERSION_PATCH) "; compiler=" __VERSION__
#ifdef BCCSPLAT_WITH_IMAGE
                                                                        "; image=openexr,png"
#else
                                                                        "; image=none"
#endif
                                                                        "; simd=highway";
}

const char* bccsplat_status_name(bccsplat_status status) {
  for (const Name& n : status_names)
    if (n.status == status) return n.name;
  return "BCCSPLAT_UNKNOWN_STATUS";
}

const char* bccsplat_last_error(void) { return last_error.data(); }

bccsplat_status bccsplat_last_lacking(uint64_t* ranges, uint64_t capacity, uint64_t* count) {
  return guard([&] {
    if (capacity > 0) require(ranges, "ranges");
    std::copy_n(last_lacking.pairs.begin(), 2 * std::min(capacity, last_lacking.count), ranges);
    if (count) *count = last_lacking.count;
  });
}

const char* bccsplat_kernel_name(uint32_t index) {
  return index < std::size(kernels) ? kernels[index] : nullptr;
}

} // extern "C"
