// SPDX-License-Identifier: Apache-2.0
// A .bcc4 file out of fuzzed bytes: checksums are set right, so that mutations reach the code behind them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fuzz {

// The input as a file, at least as long as a preamble.
[[nodiscard]] std::vector<std::byte> sealed_file(std::span<const uint8_t> input);

} // namespace fuzz
