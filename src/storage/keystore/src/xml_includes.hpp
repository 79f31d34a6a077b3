// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tinyxml2.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace pipescout::keystore {

/// An element and the file that it stands in.
struct XmlElement {
  const tinyxml2::XMLElement* element = nullptr;
  std::string file;

  [[nodiscard]] std::string_view name() const { return element->Name(); }
};

/// Throws KeystoreError: "FILE:LINE: <NAME>: WHY".
[[noreturn]] void refuse(const XmlElement& element, const std::string& why);

/// XML documents that include parts of each other (XInclude 1.0, parse="xml"), as the policies of
/// SROS 2 do: `<xi:include href="common/node.xml" xpointer="xpointer(/profile/*)"/>`. The href is a
/// path relative to the including file; the xpointer, where there is one, a path of names and '*'
/// from the root. Elements live as long as the object. Errors are KeystoreError with file and line.
class XmlIncludes {
 public:
  /// The root element. `file`: for messages, and for the paths in it.
  [[nodiscard]] XmlElement parse(const std::string& text, const std::string& file);

  /// The child elements, with what they include in place of each include.
  [[nodiscard]] std::vector<XmlElement> children(const XmlElement& parent);
  /// Those of that name.
  [[nodiscard]] std::vector<XmlElement> children(const XmlElement& parent, std::string_view name);

 private:
  void include(const XmlElement& include, std::vector<XmlElement>& found);
  void select(const XmlElement& from, std::string_view path, std::vector<XmlElement>& found);
  void add_expanded(const XmlElement& element, std::vector<XmlElement>& found);

  std::vector<std::unique_ptr<tinyxml2::XMLDocument>> documents_;
  std::vector<std::string> open_;  ///< what is being included: file and path
};

}  // namespace pipescout::keystore
