// SPDX-License-Identifier: Apache-2.0
#include "core/substitution.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "pipescout/command_line/installed_share_folder.hpp"

namespace pipescout::host {
namespace {

constexpr std::string_view kOpen = "$(";

/// Position behind the ')' that closes the "$(" at `open`.
std::size_t end_of_substitution(std::string_view text, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open + 1; i < text.size(); ++i) {
    if (text[i] == '(') {
      ++depth;
    } else if (text[i] == ')' && --depth == 0) {
      return i + 1;
    }
  }
  throw SubstitutionError("'" + std::string(text.substr(open)) + "' has no closing ')'");
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// Splits at the first run of blanks.
std::pair<std::string, std::string_view> split_word(std::string_view text) {
  const auto blank = std::min(text.find(' '), text.size());
  return {std::string(text.substr(0, blank)), trimmed(text.substr(blank))};
}

std::string value_of(std::string_view body, const SubstitutionSources& sources) {
  const auto [kind, rest] = split_word(trimmed(body));
  const auto shown = "'$(" + std::string(body) + ")'";
  if (kind == "mission_folder") {
    if (!rest.empty()) {
      throw SubstitutionError(shown + " allows nothing after 'mission_folder'");
    }
    if (!sources.mission_folder) {
      throw SubstitutionError(shown + " is not available here");
    }
    return *sources.mission_folder;
  }
  if (kind != "arg" && kind != "env" && kind != "share") {
    throw SubstitutionError(shown + ": known substitutions are arg, env, share, mission_folder");
  }
  const auto [name, fallback] = split_word(rest);
  if (name.empty()) {
    throw SubstitutionError(shown + " needs a name after '" + kind + "'");
  }
  if (kind == "share") {
    if (!fallback.empty()) {
      throw SubstitutionError(shown + " takes one package name");
    }
    if (auto folder = sources.share ? sources.share(name) : std::nullopt) {
      return *std::move(folder);
    }
    throw SubstitutionError(shown + ": no installed package '" + name +
                            "' with a share folder; is its prefix in AMENT_PREFIX_PATH?");
  }
  if (kind == "arg") {
    if (const auto argument = sources.arguments.find(name); argument != sources.arguments.end()) {
      return argument->second;
    }
  } else if (auto variable = sources.environment ? sources.environment(name) : std::nullopt) {
    return *std::move(variable);
  }
  if (fallback.empty()) {
    throw SubstitutionError(kind == "arg" ? shown + ": there is no argument '" + name + "'"
                                          : shown + ": the environment has no '" + name + "'");
  }
  return substitute(fallback, sources);
}

}  // namespace

std::string substitute(std::string_view text, const SubstitutionSources& sources) {
  std::string result;
  for (std::size_t position = 0;;) {
    const auto open = text.find(kOpen, position);
    result += text.substr(position, open - position);
    if (open == std::string_view::npos) {
      return result;
    }
    const auto end = end_of_substitution(text, open);
    result += value_of(text.substr(open + kOpen.size(), end - open - kOpen.size() - 1), sources);
    position = end;
  }
}

bool has_type_of_its_value(std::string_view text) {
  if (!text.starts_with(kOpen) || end_of_substitution(text, 0) != text.size()) {
    return false;
  }
  const auto kind = split_word(trimmed(text.substr(kOpen.size(), text.size() - kOpen.size() - 1)));
  return kind.first == "arg" || kind.first == "env";
}

ParameterValue typed_text(const std::string& text) {
  auto value = parse_parameter_value(text);
  const auto plain = trimmed(text);
  constexpr std::string_view kNotPlain = "'\"!";
  // Quotes, tags and lists are YAML that somebody wrote on purpose.
  if (plain.empty() || is_array(value.type()) || kNotPlain.find(plain.front()) != kNotPlain.npos) {
    return value;
  }
  const bool is_whole =
      value.get_if<std::string>() == nullptr && type_yaml_scalar(plain).type() == value.type();
  return is_whole ? value : ParameterValue(text);
}

SubstitutionSources process_sources() {
  SubstitutionSources sources;
  sources.environment = [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    return value != nullptr ? std::optional<std::string>(value) : std::nullopt;
  };
  sources.share = command_line::installed_share_folder;
  return sources;
}

}  // namespace pipescout::host
