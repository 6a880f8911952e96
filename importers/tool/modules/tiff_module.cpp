// SPDX-License-Identifier: Apache-2.0
#include "readers/tiff/tiff_reader.h"
#include "tool/modules/module.h"
#include "tool/output/tiff_output.h"

extern "C" {
[[gnu::visibility("default")]] extern const bcc4::Module BCC4_MODULE_ENTRY;
const bcc4::Module BCC4_MODULE_ENTRY{.open = bcc4::open_tiff, .create = bcc4::create_tiff};
}
