// SPDX-License-Identifier: Apache-2.0
#include "xml_includes.hpp"

#include <algorithm>
#include <filesystem>

#include "pipescout/keystore/certificates.hpp"
#include "pipescout/keystore/enclave_files.hpp"

namespace pipescout::keystore {
namespace {

using tinyxml2::XMLElement;

/// The namespace that a prefix stands for; empty when none is declared.
std::string_view namespace_of(const XMLElement& element, const std::string& prefix) {
  const std::string attribute = "xmlns:" + prefix;
  for (const auto* scope = &element; scope != nullptr;
       scope = scope->Parent() == nullptr ? nullptr : scope->Parent()->ToElement()) {
    if (const char* const value = scope->Attribute(attribute.c_str()); value != nullptr) {
      return value;
    }
  }
  return {};
}

bool is_include(const XmlElement& element) {
  const auto name = element.name();
  const auto colon = name.find(':');
  if (colon == std::string_view::npos || name.substr(colon + 1) != "include") {
    return false;
  }
  const std::string prefix(name.substr(0, colon));
  const auto uri = namespace_of(*element.element, prefix);
  // The second is that of a draft, which files of SROS 2 name and its parser takes too.
  if (uri != "http://www.w3.org/2001/XInclude" && uri != "http://www.w3.org/2003/XInclude") {
    refuse(element, "xmlns:" + prefix + "=\"http://www.w3.org/2001/XInclude\" is missing");
  }
  return true;
}

/// "/profile/*" of "xpointer(/profile/*)"; the root for none.
std::string_view path_in(const XmlElement& include) {
  const char* const attribute = include.element->Attribute("xpointer");
  if (attribute == nullptr) {
    return "/*";
  }
  constexpr std::string_view kBegin = "xpointer(";
  std::string_view text = attribute;
  if (text.starts_with(kBegin) && text.ends_with(')')) {
    text = text.substr(kBegin.size(), text.size() - kBegin.size() - 1);
    const bool plain = std::ranges::all_of(text, [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '/' || c == '*';
    });
    if (plain && text.size() > 1 && text.starts_with('/') && !text.ends_with('/') &&
        text.find("//") == std::string_view::npos) {
      return text;
    }
  }
  refuse(include, "xpointer=\"" + std::string(attribute) +
                      "\": only paths of names and '*' are understood, such as "
                      "xpointer(/profile/*)");
}

}  // namespace

void refuse(const XmlElement& element, const std::string& why) {
  throw KeystoreError(element.file + ":" + std::to_string(element.element->GetLineNum()) + ": <" +
                      std::string(element.name()) + ">: " + why);
}

XmlElement XmlIncludes::parse(const std::string& text, const std::string& file) {
  auto& document = *documents_.emplace_back(std::make_unique<tinyxml2::XMLDocument>());
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    throw KeystoreError(file + ":" + std::to_string(document.ErrorLineNum()) +
                        ": is no XML: " + document.ErrorName());
  }
  if (document.RootElement() == nullptr) {
    throw KeystoreError(file + ": holds no element");
  }
  return {document.RootElement(), file};
}

std::vector<XmlElement> XmlIncludes::children(const XmlElement& parent) {
  std::vector<XmlElement> found;
  for (const auto* child = parent.element->FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    add_expanded({child, parent.file}, found);
  }
  return found;
}

std::vector<XmlElement> XmlIncludes::children(const XmlElement& parent, std::string_view name) {
  auto found = children(parent);
  std::erase_if(found, [&](const XmlElement& child) { return child.name() != name; });
  return found;
}

void XmlIncludes::add_expanded(const XmlElement& element, std::vector<XmlElement>& found) {
  if (is_include(element)) {
    include(element, found);
  } else {
    found.push_back(element);
  }
}

void XmlIncludes::include(const XmlElement& include, std::vector<XmlElement>& found) {
  const char* const href = include.element->Attribute("href");
  if (href == nullptr || *href == '\0') {
    refuse(include, "attribute 'href' is missing");
  }
  if (const char* const parse = include.element->Attribute("parse");
      parse != nullptr && std::string_view(parse) != "xml") {
    refuse(include, std::string("parse=\"") + parse + "\": only \"xml\" is understood");
  }
  const auto path = path_in(include);
  const auto file =
      (std::filesystem::path(include.file).parent_path() / href).lexically_normal().string();
  const std::string key = file + " " + std::string(path);
  if (std::ranges::find(open_, key) != open_.end()) {
    refuse(include, file + " includes itself");
  }
  open_.push_back(key);
  std::string text;
  try {
    text = content_of(file);
  } catch (const KeystoreError& error) {
    refuse(include, error.what());
  }
  const auto before = found.size();
  const XmlElement root = parse(text, file);
  const auto first_end = path.find('/', 1);
  if (const auto first = path.substr(1, std::min(first_end, path.size()) - 1);
      first == "*" || first == root.name()) {
    select(root, first_end == std::string_view::npos ? "" : path.substr(first_end), found);
  }
  if (found.size() == before) {
    refuse(include, file + " has nothing at " + std::string(path));
  }
  open_.pop_back();
}

/// `path`: what is left of it, "/profiles/*" or nothing.
void XmlIncludes::select(const XmlElement& from, std::string_view path,
                         std::vector<XmlElement>& found) {
  if (path.empty()) {
    add_expanded(from, found);
    return;
  }
  const auto end = std::min(path.find('/', 1), path.size());
  const auto name = path.substr(1, end - 1);
  for (const auto& child : children(from)) {
    if (name == "*" || name == child.name()) {
      select(child, path.substr(end), found);
    }
  }
}

}  // namespace pipescout::keystore
