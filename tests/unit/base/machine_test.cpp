// SPDX-License-Identifier: Apache-2.0
#include "base/machine.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <string>

namespace bccsplat {
namespace {

TEST(Machine, HasTheMemoryThatTheSystemTells) {
  std::ifstream info("/proc/meminfo");
  std::string name;
  uint64_t kibibytes = 0;
  if (!(info >> name >> kibibytes) || name != "MemTotal:") GTEST_SKIP() << "no /proc/meminfo";
  // A container may be told of less than there is; Wine tells a page less.
  constexpr uint64_t page = 4096;
  EXPECT_GE(machine_memory() + page, kibibytes * 1024);
  EXPECT_LT(machine_memory(), uint64_t{1} << 50);
}

} // namespace
} // namespace bccsplat
