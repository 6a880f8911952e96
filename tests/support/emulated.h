// SPDX-License-Identifier: Apache-2.0
// What is left out where an emulator runs the tests (qemu), which takes fifty times as long.
#pragma once

#include <cstddef>
#include <vector>

namespace bccsplat::test {

#ifdef BCCSPLAT_EMULATED
inline constexpr bool emulated = true;
#else
inline constexpr bool emulated = false;
#endif

// Returns all of `cases`, or every `nth` of them under an emulator: for cases that take other ways through
// code which other tests run there, too.
template<class Case> [[nodiscard]] std::vector<Case> some(const std::vector<Case>& cases, size_t nth) {
  std::vector<Case> chosen;
  for (size_t i = 0; i < cases.size(); i += emulated ? nth : 1) chosen.push_back(cases[i]);
  return chosen;
}

} // namespace bccsplat::test
