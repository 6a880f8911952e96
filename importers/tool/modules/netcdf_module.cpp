// SPDX-License-Identifier: Apache-2.0
#include "readers/netcdf/netcdf_reader.h"
#include "tool/modules/module.h"

extern "C" {
[[gnu::visibility("default")]] extern const bcc4::Module BCC4_MODULE_ENTRY;
const bcc4::Module BCC4_MODULE_ENTRY{bcc4::open_netcdf};
}
