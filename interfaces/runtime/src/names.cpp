// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/names.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace pipescout {
namespace {

// Limits of rmw: the DDS name of 255 characters less the longest prefix and suffix, and for a
// namespace also less the shortest name below it.
constexpr std::size_t kMaxNodeName = 255;
constexpr std::size_t kMaxTopicName = 247;
constexpr std::size_t kMaxNamespace = kMaxTopicName - 2;

// The classification of <cctype> depends on the locale; names do not.
constexpr bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
constexpr bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
constexpr bool is_word(char c) {
  return is_letter(c) || is_digit(c) || c == '_';
}

constexpr std::string_view kNodeNameKind = "node name";
constexpr std::string_view kNamespaceKind = "namespace";
constexpr std::string_view kTopicNameKind = "topic name";
constexpr std::string_view kTypeNameKind = "type name";
constexpr std::string_view kRemapRuleKind = "remapping rule";

[[noreturn]] void refuse(std::string_view kind, std::string_view name, std::size_t position,
                         std::string_view reason) {
  throw InvalidName(kind, std::string(name), position, reason);
}

// Characters that could confuse a terminal or a log are shown as escapes.
std::string printable(std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      result += "\\x";
      result += kHex[byte >> 4U];
      result += kHex[byte & 0xFU];
    } else {
      result += c;
    }
  }
  return result;
}

void validate_absolute(std::string_view kind, std::string_view name, std::size_t max_length) {
  if (name.empty()) {
    refuse(kind, name, 0, "must not be empty");
  }
  if (name.front() != '/') {
    refuse(kind, name, 0, "must be absolute: it must begin with '/'");
  }
  if (name.back() == '/') {
    refuse(kind, name, name.size() - 1, "must not end with '/'");
  }
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (!is_word(c) && c != '/') {
      refuse(kind, name, i, "must have only letters, digits, '_' and '/'");
    }
    if (i > 0 && name[i - 1] == '/') {
      if (c == '/') {
        refuse(kind, name, i, "must not have repeated '/'");
      }
      if (is_digit(c)) {
        refuse(kind, name, i, "must not have a part that begins with a digit");
      }
    }
  }
  if (name.size() > max_length) {
    refuse(kind, name, max_length,
           "must have at most " + std::to_string(max_length) + " characters");
  }
}

std::string below(std::string_view ns, std::string_view name) {
  std::string result(ns);
  if (result != "/") {
    result += '/';
  }
  result += name;
  return result;
}

// Replaces every {...} in a name that is known to be valid.
std::string substitute(std::string_view name, const NodeName& node) {
  std::string result;
  std::size_t position = 0;
  while (position < name.size()) {
    const std::size_t open = name.find('{', position);
    if (open == std::string_view::npos) {
      break;
    }
    const std::size_t close = name.find('}', open);
    const std::string_view key = name.substr(open + 1, close - open - 1);
    result += name.substr(position, open - position);
    if (key == "node") {
      result += node.name;
    } else if (key == "ns" || key == "namespace") {
      // The root namespace before "/x" would give "//x".
      const bool slash_follows = close + 1 < name.size() && name[close + 1] == '/';
      result += node.ns == "/" && slash_follows ? "" : node.ns;
    } else {
      refuse(kTopicNameKind, name, open,
             "has an unknown substitution; known are {node}, {ns} and {namespace}");
    }
    position = close + 1;
  }
  result += name.substr(position);
  return result;
}

enum class Endpoint { kTopic, kService };

bool applies_to(const RemapRule& rule, Endpoint endpoint) {
  return rule.kind == RemapRule::Kind::kTopicOrService ||
         (rule.kind == RemapRule::Kind::kTopic && endpoint == Endpoint::kTopic) ||
         (rule.kind == RemapRule::Kind::kService && endpoint == Endpoint::kService);
}

bool applies_to(const RemapRule& rule, const std::string& node_name) {
  return rule.node.empty() || rule.node == node_name;
}

std::string resolve_name(std::string_view name, const NodeName& node, const RemapRules& rules,
                         Endpoint endpoint) {
  std::string expanded = expand_topic_name(name, node);
  for (const RemapRule& rule : rules) {
    if (applies_to(rule, endpoint) && applies_to(rule, node.name) &&
        expand_topic_name(rule.from, node) == expanded) {
      expanded = expand_topic_name(rule.to, node);
      break;
    }
  }
  validate_full_topic_name(expanded);
  return expanded;
}

struct Mangling {
  DdsTopicKind kind;
  std::string_view prefix;
  std::string_view suffix;
};

constexpr Mangling kManglings[] = {{DdsTopicKind::kTopic, "rt", ""},
                                   {DdsTopicKind::kServiceRequest, "rq", "Request"},
                                   {DdsTopicKind::kServiceReply, "rr", "Reply"}};

bool is_identifier(std::string_view text) {
  return !text.empty() && !is_digit(text.front()) && std::all_of(text.begin(), text.end(), is_word);
}

struct TypeParts {
  std::string_view package;
  std::string_view kind;
  std::string_view type;
};

constexpr std::string_view kDdsMarker = "::dds_::";

// "pkg::msg::dds_::Type_" in its parts.
std::optional<TypeParts> split_dds_type(std::string_view dds_name) {
  const std::size_t marker = dds_name.find(kDdsMarker);
  if (marker == std::string_view::npos || dds_name.back() != '_') {
    return std::nullopt;
  }
  const std::string_view scope = dds_name.substr(0, marker);
  const std::size_t colons = scope.find("::");
  if (colons == std::string_view::npos) {
    return std::nullopt;
  }
  const std::size_t type_at = marker + kDdsMarker.size();
  if (type_at >= dds_name.size()) {
    return std::nullopt;
  }
  const TypeParts parts{scope.substr(0, colons), scope.substr(colons + 2),
                        dds_name.substr(type_at, dds_name.size() - type_at - 1)};
  if (!is_identifier(parts.package) || !is_identifier(parts.kind) || !is_identifier(parts.type)) {
    return std::nullopt;
  }
  return parts;
}

std::string join_type(const TypeParts& parts, std::string_view type) {
  std::string result(parts.package);
  result += '/';
  result += parts.kind;
  result += '/';
  result += type;
  return result;
}

// Optimal string alignment: insertions, deletions, replacements and swaps of neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_previous(b.size() + 1);
  std::vector<std::size_t> previous(b.size() + 1);
  std::vector<std::size_t> current(b.size() + 1);
  std::iota(previous.begin(), previous.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        current[j] = std::min(current[j], before_previous[j - 2] + 1);
      }
    }
    std::swap(before_previous, previous);
    std::swap(previous, current);
  }
  return previous[b.size()];
}

}  // namespace

InvalidName::InvalidName(std::string_view what_it_names, std::string name, std::size_t position,
                         std::string_view reason)
    : std::invalid_argument("invalid " + std::string(what_it_names) + " '" + printable(name) +
                            "': " + std::string(reason) + " (at position " +
                            std::to_string(position) + ")"),
      name_(std::move(name)),
      position_(position) {}

void validate_node_name(std::string_view name) {
  if (name.empty()) {
    refuse(kNodeNameKind, name, 0, "must not be empty");
  }
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!is_word(name[i])) {
      refuse(kNodeNameKind, name, i, "must have only letters, digits and '_'");
    }
  }
  if (is_digit(name.front())) {
    refuse(kNodeNameKind, name, 0, "must not begin with a digit");
  }
  if (name.size() > kMaxNodeName) {
    refuse(kNodeNameKind, name, kMaxNodeName,
           "must have at most " + std::to_string(kMaxNodeName) + " characters");
  }
}

void validate_namespace(std::string_view name) {
  if (name == "/") {
    return;
  }
  validate_absolute(kNamespaceKind, name, kMaxNamespace);
}

void validate_topic_name(std::string_view name) {
  constexpr auto kNone = std::string_view::npos;
  if (name.empty()) {
    refuse(kTopicNameKind, name, 0, "must not be empty");
  }
  if (name.back() == '/') {
    refuse(kTopicNameKind, name, name.size() - 1, "must not end with '/'");
  }
  if (name.front() == '~' && name.size() > 1 && name[1] != '/') {
    refuse(kTopicNameKind, name, 1, "must have '/' after '~'");
  }
  std::size_t open = kNone;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool begins_part = i == 0 || name[i - 1] == '/';
    if (open != kNone) {
      if (c == '}') {
        if (i == open + 1) {
          refuse(kTopicNameKind, name, i, "must not have an empty substitution");
        }
        open = kNone;
      } else if (!is_word(c)) {
        refuse(kTopicNameKind, name, i, "substitutions must have only letters, digits and '_'");
      } else if (is_digit(c) && i == open + 1) {
        refuse(kTopicNameKind, name, i, "substitutions must not begin with a digit");
      }
    } else if (c == '{') {
      open = i;
    } else if (c == '}') {
      refuse(kTopicNameKind, name, i, "must not have unbalanced braces");
    } else if (c == '~') {
      if (i != 0) {
        refuse(kTopicNameKind, name, i, "must have '~' only as its first character");
      }
    } else if (c == '/') {
      if (i != 0 && begins_part) {
        refuse(kTopicNameKind, name, i, "must not have repeated '/'");
      }
    } else if (!is_word(c)) {
      refuse(kTopicNameKind, name, i, "must have only letters, digits, '_', '/', '~' and braces");
    } else if (begins_part && is_digit(c)) {
      refuse(kTopicNameKind, name, i, "must not have a part that begins with a digit");
    }
  }
  if (open != kNone) {
    refuse(kTopicNameKind, name, open, "must not have unbalanced braces");
  }
}

void validate_full_topic_name(std::string_view name) {
  validate_absolute(kTopicNameKind, name, kMaxTopicName);
}

std::string NodeName::fully_qualified() const {
  return below(ns, name);
}

std::string NodeName::logger_name() const {
  std::string result = fully_qualified().substr(1);
  std::replace(result.begin(), result.end(), '/', '.');
  return result;
}

void NodeName::validate() const {
  validate_node_name(name);
  validate_namespace(ns);
}

NodeName NodeName::parse(std::string_view fully_qualified) {
  const std::size_t slash = fully_qualified.rfind('/');
  NodeName result;
  if (slash == std::string_view::npos) {
    result.name = fully_qualified;
  } else {
    if (slash > 0) {
      result.ns = fully_qualified.substr(0, slash);
      // Not validate_namespace(): of "//n" the part before the last '/' is no root namespace.
      validate_absolute(kNamespaceKind, result.ns, kMaxNamespace);
    }
    result.name = fully_qualified.substr(slash + 1);
  }
  result.validate();
  return result;
}

std::string join_namespaces(std::string_view parent, std::string_view ns) {
  validate_namespace(parent);
  if (ns.empty()) {
    return std::string(parent);
  }
  std::string result = ns.front() == '/' ? std::string(ns) : below(parent, ns);
  validate_namespace(result);
  return result;
}

std::string expand_topic_name(std::string_view name, const NodeName& node) {
  validate_topic_name(name);
  node.validate();
  std::string result = substitute(name, node);
  if (result.front() == '~') {
    return node.fully_qualified() + result.substr(1);
  }
  return result.front() == '/' ? result : below(node.ns, result);
}

RemapRule RemapRule::parse(std::string_view text) {
  constexpr std::string_view kSeparator = ":=";
  constexpr std::string_view kTopicScheme = "rostopic://";
  constexpr std::string_view kServiceScheme = "rosservice://";
  const std::size_t separator = text.find(kSeparator);
  if (separator == std::string_view::npos) {
    refuse(kRemapRuleKind, text, text.size(), "must have the form from:=to");
  }
  RemapRule rule;
  std::string_view from = text.substr(0, separator);
  rule.to = text.substr(separator + kSeparator.size());

  const auto take_scheme = [&] {
    if (from.starts_with(kTopicScheme)) {
      rule.kind = Kind::kTopic;
      from.remove_prefix(kTopicScheme.size());
    } else if (from.starts_with(kServiceScheme)) {
      rule.kind = Kind::kService;
      from.remove_prefix(kServiceScheme.size());
    }
  };
  take_scheme();
  if (const std::size_t colon = from.find(':');
      rule.kind == Kind::kTopicOrService && colon != std::string_view::npos) {
    rule.node = from.substr(0, colon);
    validate_node_name(rule.node);
    from.remove_prefix(colon + 1);
    take_scheme();
  }
  if (from == "__node" || from == "__name") {
    if (rule.kind != Kind::kTopicOrService) {
      refuse(kRemapRuleKind, text, 0, "a node name has no scheme");
    }
    rule.kind = Kind::kNodeName;
    validate_node_name(rule.to);
  } else if (from == "__ns") {
    if (rule.kind != Kind::kTopicOrService) {
      refuse(kRemapRuleKind, text, 0, "a namespace has no scheme");
    }
    rule.kind = Kind::kNamespace;
    validate_namespace(rule.to);
  } else {
    rule.from = from;
    validate_topic_name(rule.from);
    validate_topic_name(rule.to);
  }
  return rule;
}

NodeName remap_node(const NodeName& node, const RemapRules& rules) {
  const auto first = [&rules](RemapRule::Kind kind, const std::string& node_name) {
    return std::find_if(rules.begin(), rules.end(), [&](const RemapRule& rule) {
      return rule.kind == kind && applies_to(rule, node_name);
    });
  };
  NodeName result = node;
  if (const auto rule = first(RemapRule::Kind::kNodeName, result.name); rule != rules.end()) {
    result.name = rule->to;
  }
  if (const auto rule = first(RemapRule::Kind::kNamespace, result.name); rule != rules.end()) {
    result.ns = rule->to;
  }
  result.validate();
  return result;
}

std::string resolve_topic_name(std::string_view name, const NodeName& node,
                               const RemapRules& rules) {
  return resolve_name(name, node, rules, Endpoint::kTopic);
}

std::string resolve_service_name(std::string_view name, const NodeName& node,
                                 const RemapRules& rules) {
  return resolve_name(name, node, rules, Endpoint::kService);
}

std::string mangle_topic_name(std::string_view name, DdsTopicKind kind) {
  validate_full_topic_name(name);
  const auto mangling = std::find_if(std::begin(kManglings), std::end(kManglings),
                                     [kind](const Mangling& m) { return m.kind == kind; });
  std::string result(mangling->prefix);
  result += name;
  result += mangling->suffix;
  return result;
}

std::optional<DemangledTopic> demangle_topic_name(std::string_view dds_name) {
  for (const Mangling& mangling : kManglings) {
    const std::size_t added = mangling.prefix.size() + mangling.suffix.size();
    // The shortest name is "/x"; what follows the prefix is the name's own '/'.
    if (dds_name.size() >= added + 2 && dds_name.starts_with(mangling.prefix) &&
        dds_name[mangling.prefix.size()] == '/' && dds_name.ends_with(mangling.suffix)) {
      return DemangledTopic{mangling.kind, std::string(dds_name.substr(mangling.prefix.size(),
                                                                       dds_name.size() - added))};
    }
  }
  return std::nullopt;
}

std::string mangle_type_name(std::string_view name) {
  const std::size_t first = name.find('/');
  const std::size_t last = name.rfind('/');
  if (first == std::string_view::npos || first == last || !is_identifier(name.substr(0, first)) ||
      !is_identifier(name.substr(first + 1, last - first - 1)) ||
      !is_identifier(name.substr(last + 1))) {
    refuse(kTypeNameKind, name, first == std::string_view::npos ? name.size() : first,
           "must have the form package/kind/Type");
  }
  std::string result(name.substr(0, first));
  result += "::";
  result += name.substr(first + 1, last - first - 1);
  result += kDdsMarker;
  result += name.substr(last + 1);
  result += '_';
  return result;
}

std::optional<std::string> demangle_type_name(std::string_view dds_name) {
  const std::optional<TypeParts> parts = split_dds_type(dds_name);
  if (!parts) {
    return std::nullopt;
  }
  return join_type(*parts, parts->type);
}

std::optional<std::string> demangle_service_type_name(std::string_view dds_name) {
  const std::optional<TypeParts> parts = split_dds_type(dds_name);
  // Services of actions are in the scope `action`.
  if (!parts || (parts->kind != "srv" && parts->kind != "action")) {
    return std::nullopt;
  }
  for (const std::string_view suffix : {"_Request", "_Response"}) {
    if (parts->type.size() > suffix.size() && parts->type.ends_with(suffix)) {
      return join_type(*parts, parts->type.substr(0, parts->type.size() - suffix.size()));
    }
  }
  return std::nullopt;
}

std::optional<std::string> nearest_name(std::string_view misspelt,
                                        const std::vector<std::string>& known) {
  std::optional<std::string> nearest;
  std::size_t smallest = 0;
  for (const std::string& candidate : known) {
    const std::size_t longer = std::max(candidate.size(), misspelt.size());
    const std::size_t allowed = std::max<std::size_t>(1, longer / 3);
    const std::size_t distance = edit_distance(misspelt, candidate);
    if (distance <= allowed && distance < longer && (!nearest || distance < smallest)) {
      nearest = candidate;
      smallest = distance;
    }
  }
  return nearest;
}

}  // namespace pipescout
