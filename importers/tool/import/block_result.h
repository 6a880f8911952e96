// SPDX-License-Identifier: Apache-2.0
// What importing a block told, in a file beside it: a later run that finds the block there tells it as well.
#pragma once

#include <string>

#include "tool/import/summary.h"

namespace bcc4 {

// Writes the errors of a block, and which of its values were not finite, for this build of bcc4 alone. Where
// that fails, the block will be written again.
void keep_block_result(const ImportResult& result, const std::string& block);
// Reads them; returns false, and leaves `result` as it was, where they are not there, or not all of them.
[[nodiscard]] bool read_block_result(const std::string& block, size_t channels, ImportResult& result);
void remove_block_result(const std::string& block);

} // namespace bcc4
