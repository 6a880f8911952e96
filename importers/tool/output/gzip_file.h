// SPDX-License-Identifier: Apache-2.0
// A file whose bytes are packed with gzip on their way into it.
#pragma once

#include <memory>
#include <string>

#include "tool/output/byte_sink.h"

namespace bcc4 {

[[nodiscard]] std::unique_ptr<ByteSink> create_gzip(const std::string& path, bool overwrite);

} // namespace bcc4
