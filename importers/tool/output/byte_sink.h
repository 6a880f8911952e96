// SPDX-License-Identifier: Apache-2.0
// Where bytes of a file go: as they are (OutputFile), or packed (GzipFile).
#pragma once

#include <cstddef>
#include <span>

namespace bcc4 {

class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual void write(std::span<const std::byte> bytes) = 0;
  virtual void finish() = 0;
};

} // namespace bcc4
