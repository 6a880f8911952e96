// SPDX-License-Identifier: Apache-2.0
#include "readers/vdb/vdb_reader.h"
#include "tool/modules/module.h"
#include "tool/output/vdb_writer.h"

extern "C" {
[[gnu::visibility("default")]] extern const bcc4::Module BCC4_MODULE_ENTRY;
const bcc4::Module BCC4_MODULE_ENTRY{.open = bcc4::open_vdb, .write_grid = bcc4::write_vdb_grid};
}
