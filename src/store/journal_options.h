// SPDX-License-Identifier: Apache-2.0
// The options of a writer in words, as its journal keeps them: whoever resumes it hears at once which of them
// is another one.
#pragma once

#include <string>

#include "base/vec.h"
#include "formats/bcc4/write/journal.h"
#include "store/settings.h"

namespace bccsplat {

// All that the bytes of a file depend on and that is known before its first data. lead, planes: layers at
// each end of time and planes outside the faces, as of frames; kernel: the one recommended.
[[nodiscard]] JournalOptions journal_options(const WriterSettings& settings, const std::string& kernel,
                                             int32_t lead, const Int3& planes);

[[nodiscard]] const char* name_of(LatticeKind kind);

} // namespace bccsplat
