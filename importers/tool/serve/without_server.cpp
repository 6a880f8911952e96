// SPDX-License-Identifier: Apache-2.0
// The server where the tool has none. Any other one of files, with ranges, does as well.
#include "readers/error.h"
#include "tool/serve/http_server.h"

namespace bcc4 {

void serve_files(const Serving& /*serving*/) {
  fail_input("view: this bcc4 has no server (BCCSPLAT_WITH_MICROHTTPD); let another one (with ranges) serve "
             "examples/web and the file, and open index.html?url=FILE there");
}

} // namespace bcc4
