// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>

#include "pipescout/keystore/certificates.hpp"
#include "xml_includes.hpp"

namespace pipescout::keystore {
namespace {

using tinyxml2::XMLElement;

unsigned domain_in(const XMLElement& element) {
  std::string_view text = element.GetText() == nullptr ? "" : element.GetText();
  text.remove_suffix(text.size() - (text.find_last_not_of(" \t\r\n") + 1));
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  const auto* const end = text.data() + text.size();
  unsigned domain = 0;
  const auto [stop, error] = std::from_chars(text.data(), end, domain);
  if (error != std::errc{} || stop != end) {
    throw KeystoreError(std::string("<") + element.Name() + ">" + std::string(text) + "</" +
                        element.Name() + "> is no domain");
  }
  return domain;
}

unsigned bound(const XMLElement& range, const char* name, unsigned otherwise) {
  const auto* const element = range.FirstChildElement(name);
  return element == nullptr ? otherwise : domain_in(*element);
}

void collect(const XMLElement& rule, std::vector<DomainRange>& found) {
  for (const auto* list = rule.FirstChildElement("domains"); list != nullptr;
       list = list->NextSiblingElement("domains")) {
    for (const auto* entry = list->FirstChildElement(); entry != nullptr;
         entry = entry->NextSiblingElement()) {
      const std::string_view name = entry->Name();
      if (name == "id") {
        const unsigned domain = domain_in(*entry);
        found.push_back({domain, domain});
      } else if (name == "id_range") {
        found.push_back(
            {bound(*entry, "min", 0), bound(*entry, "max", std::numeric_limits<unsigned>::max())});
      }
    }
  }
}

void search(const XMLElement& element, std::vector<DomainRange>& found) {
  const std::string_view name = element.Name();
  if (name == "allow_rule" || name == "domain_rule") {
    collect(element, found);
    return;
  }
  for (const auto* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    search(*child, found);
  }
}

}  // namespace

std::vector<DomainRange> domains_in(const std::string& document) {
  std::vector<DomainRange> found;
  XmlIncludes files;
  search(*files.parse(document, "the document").element, found);
  return found;
}

std::string to_string(const std::vector<DomainRange>& domains) {
  std::string text;
  for (const auto& domain : domains) {
    text += (text.empty() ? "" : ", ") + std::to_string(domain.first);
    if (domain.last == std::numeric_limits<unsigned>::max()) {
      text += " and above";
    } else if (domain.last != domain.first) {
      text += " to " + std::to_string(domain.last);
    }
  }
  return text.empty() ? "none" : text;
}

}  // namespace pipescout::keystore
