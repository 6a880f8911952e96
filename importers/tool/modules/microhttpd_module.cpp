// SPDX-License-Identifier: Apache-2.0
#include "tool/modules/module.h"
#include "tool/serve/http_server.h"

extern "C" {
[[gnu::visibility("default")]] extern const bcc4::Module BCC4_MODULE_ENTRY;
const bcc4::Module BCC4_MODULE_ENTRY{.serve = bcc4::serve_files};
}
