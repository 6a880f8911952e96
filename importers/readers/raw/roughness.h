// Suspicions about raw data: a wrong byte order or swapped axes make neighbours differ wildly.
#pragma once

#include <string>
#include <vector>

#include "readers/dense_series.h"

namespace bcc4 {

// `bytes`: one frame in file order, native byte order as declared, axes without time. Returns warnings,
// mostly none.
[[nodiscard]] std::vector<std::string> find_suspicions(const Bytes& bytes, Type type,
                                                       const std::vector<FileAxis>& axes);

} // namespace bcc4
