// SPDX-License-Identifier: Apache-2.0
// As much XML as VTK's files need: elements, attributes and text, without DTDs or entities beyond the five.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bcc4 {

struct XmlElement {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string_view text; // between the start tag and the first child or the end tag; in the parsed document
  std::vector<XmlElement> children;

  // Returns "" when the attribute is absent.
  [[nodiscard]] std::string_view attribute(std::string_view key) const;
  // Returns the first child of that name, or null.
  [[nodiscard]] const XmlElement* child(std::string_view key) const;
};

struct XmlDocument {
  XmlElement root;
  // Offset behind the start tag of the element to stop at, when it was met.
  size_t stopped_at = std::string_view::npos;
};

// Parses until the end of the root element, or until the start tag of an element named `stop_at` has been
// read. `path` is for error texts. The document borrows `text`.
[[nodiscard]] XmlDocument parse_xml(std::string_view text, const std::string& path,
                                    std::string_view stop_at = {});

} // namespace bcc4
