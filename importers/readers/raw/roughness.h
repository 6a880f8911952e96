// SPDX-License-Identifier: Apache-2.0
// Suspicions about raw data: a wrong byte order, a wrong sign or swapped axes make neighbours differ wildly.
#pragma once

#include <string>
#include <vector>

#include "readers/dense_series.h"

namespace bcc4 {

// `bytes` are one frame in file order, brought to native byte order as declared, with axes without time.
// Returns warnings, mostly none.
[[nodiscard]] std::vector<std::string> find_suspicions(const Bytes& bytes, Type type,
                                                       const std::vector<FileAxis>& axes);

} // namespace bcc4
