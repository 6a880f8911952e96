// SPDX-License-Identifier: Apache-2.0
// A .bcc4 file out of fuzzed bytes. Zeros of the preamble are left out of the input and checksums are set
// right, so that mutations reach the code behind them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fuzz {

// Input: header (64 bytes), root A (128), root B (128), then the file from offset 12288 on.
[[nodiscard]] std::vector<std::byte> sealed_file(std::span<const uint8_t> input);
// The reverse, for seeds; checksums stay as they are.
[[nodiscard]] std::vector<uint8_t> unsealed(std::span<const std::byte> file);

} // namespace fuzz
