// SPDX-License-Identifier: Apache-2.0
// A recursive parser of the small part of XML that VTK's files need, which may stop at the start of an
// element whose content is no XML.
#include "readers/vti/xml.h"

#include "readers/error.h"

namespace bcc4 {
namespace {

constexpr int kDepthLimit = 64;

class XmlParser {
 public:
  XmlParser(std::string_view text, const std::string& path, std::string_view stop_at)
      : text_(text), path_(path), stop_at_(stop_at) {}

  XmlDocument parse() {
    skip_to_element();
    XmlDocument document;
    element(document.root, 0);
    document.stopped_at = stopped_at_;
    return document;
  }

 private:
  template<class... Parts> [[noreturn]] void refuse(const Parts&... parts) const {
    fail_input(path_, ": XML at offset ", at_, ": ", parts...);
  }
  [[nodiscard]] bool looking_at(std::string_view s) const { return text_.substr(at_).starts_with(s); }
  void skip_blanks() { at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size()); }
  void skip_past(std::string_view end) {
    const size_t found = text_.find(end, at_);
    if (found == std::string_view::npos) refuse("\"", end, "\" is missing");
    at_ = found + end.size();
  }
  // Skips a comment or a declaration; returns false when there is none here.
  bool skip_extras() {
    if (looking_at("<!--"))
      skip_past("-->");
    else if (looking_at("<?"))
      skip_past("?>");
    else if (looking_at("<!DOCTYPE"))
      refuse("document types are not read");
    else
      return false;
    return true;
  }
  void skip_to_element() {
    do {
      skip_blanks();
    } while (skip_extras());
    if (!looking_at("<")) refuse("no element");
  }

  std::string name() {
    const size_t end = std::min(text_.find_first_of(" \t\r\n/>=<\"'", at_), text_.size());
    if (end == at_) refuse("a name is missing");
    std::string out(text_.substr(at_, end - at_));
    at_ = end;
    return out;
  }

  static std::string unescaped(std::string_view value) {
    static constexpr std::pair<std::string_view, char> entities[] = {
        {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
    std::string out;
    for (size_t i = 0; i < value.size();) {
      bool found = false;
      for (const auto& [entity, c] : entities) {
        if (!value.substr(i).starts_with(entity)) continue;
        out += c;
        i += entity.size();
        found = true;
        break;
      }
      if (!found) out += value[i++];
    }
    return out;
  }

  void attribute(XmlElement& e) {
    std::string key = name();
    skip_blanks();
    if (!looking_at("=")) refuse("attribute ", key, " has no value");
    ++at_;
    skip_blanks();
    if (!looking_at("\"") && !looking_at("'")) refuse("the value of ", key, " is not quoted");
    const char quote = text_[at_++];
    const size_t end = text_.find(quote, at_);
    if (end == std::string_view::npos) refuse("the value of ", key, " does not end");
    e.attributes.emplace_back(std::move(key), unescaped(text_.substr(at_, end - at_)));
    at_ = end + 1;
  }

  // Parses an element; returns false when the parser stopped inside it.
  bool element(XmlElement& e, int depth) {
    if (depth > kDepthLimit) refuse("more than ", kDepthLimit, " elements inside each other");
    ++at_; // <
    e.name = name();
    for (;;) {
      skip_blanks();
      if (looking_at("/>")) {
        at_ += 2;
        return true;
      }
      if (looking_at(">")) break;
      if (at_ >= text_.size()) refuse("element ", e.name, " does not end");
      attribute(e);
    }
    ++at_; // >
    if (!stop_at_.empty() && e.name == stop_at_) {
      stopped_at_ = at_;
      return false;
    }
    return content(e, depth);
  }

  bool content(XmlElement& e, int depth) {
    bool first = true;
    for (;;) {
      const size_t tag = text_.find('<', at_);
      if (tag == std::string_view::npos) refuse("element ", e.name, " does not end");
      if (first) e.text = text_.substr(at_, tag - at_);
      first = false;
      at_ = tag;
      if (skip_extras()) continue;
      if (looking_at("</")) {
        at_ += 2;
        if (name() != e.name) refuse("element ", e.name, " is closed by another name");
        skip_blanks();
        if (!looking_at(">")) refuse("\">\" is missing");
        ++at_;
        return true;
      }
      e.children.emplace_back();
      if (!element(e.children.back(), depth + 1)) return false;
    }
  }

  std::string_view text_;
  const std::string& path_;
  std::string_view stop_at_;
  size_t at_ = 0;
  size_t stopped_at_ = std::string_view::npos;
};

} // namespace

std::string_view XmlElement::attribute(std::string_view key) const {
  for (const auto& [k, value] : attributes)
    if (k == key) return value;
  return {};
}

const XmlElement* XmlElement::child(std::string_view key) const {
  for (const XmlElement& c : children)
    if (c.name == key) return &c;
  return nullptr;
}

XmlDocument parse_xml(std::string_view text, const std::string& path, std::string_view stop_at) {
  return XmlParser(text, path, stop_at).parse();
}

} // namespace bcc4
