// SPDX-License-Identifier: Apache-2.0
#include "readers/vti/xml.h"

#include "readers/error.h"

namespace bcc4 {

void parse_xml(std::string& text, const std::string& path, pugi::xml_document& document) {
  const pugi::xml_parse_result result =
      document.load_buffer_inplace(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result) fail_input(path, ": XML at offset ", result.offset, ": ", result.description());
}

} // namespace bcc4
