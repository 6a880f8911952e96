// SPDX-License-Identifier: Apache-2.0
// XML of VTK's files, parsed by pugixml: no document types, no entities beyond the five, no depth that it
// could not bear.
#pragma once

#include <pugixml.hpp>

#include <string>

namespace bcc4 {

// Parses `text` in place: it must outlive the document and is no longer the text. `path` is for the error.
void parse_xml(std::string& text, const std::string& path, pugi::xml_document& document);

} // namespace bcc4
