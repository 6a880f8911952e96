// SPDX-License-Identifier: Apache-2.0
// Changes a file as its format has it: a field of a record, of a page, of a root, or the bytes of a chunk or
// of a block, in place.
#pragma once

#include <cstdint>
#include <span>

namespace fuzz {

// Changes one part of the input of sealed_file(), chosen by `seed`; the same seed makes the same of the same
// input on every machine. Parts that the file does not lead to, or that are deflated, are bytes like others.
void change_file(std::span<uint8_t> input, uint32_t seed);

} // namespace fuzz
