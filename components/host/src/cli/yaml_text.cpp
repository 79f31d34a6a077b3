// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdint>
#include <cstdio>
#include <regex>
#include <string>
#include <vector>

#include "cli/message_text.hpp"

/// How PyYAML, which `ros2` prints with, writes a text.
namespace pipescout::host {
namespace {

constexpr char32_t kReplacement = 0xFFFD;

std::vector<char32_t> decode_utf8(std::string_view text) {
  std::vector<char32_t> result;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t size = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
    char32_t code = size == 1 ? first : first & (0x7FU >> size);
    bool good = size != 0 && i + size <= text.size();
    for (std::size_t k = 1; good && k < size; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      good = (next & 0xC0U) == 0x80U;
      code = code << 6U | (next & 0x3FU);
    }
    constexpr std::array<char32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};
    good = good && code >= kSmallest[size] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
    result.push_back(good ? code : kReplacement);
    i += good ? size : 1;
  }
  return result;
}

void append_utf8(std::string& out, char32_t code) {
  const auto push = [&](char32_t byte) { out += static_cast<char>(byte); };
  if (code < 0x80) {
    push(code);
  } else if (code < 0x800) {
    push(0xC0U | code >> 6U);
    push(0x80U | (code & 0x3FU));
  } else if (code < 0x10000) {
    push(0xE0U | code >> 12U);
    push(0x80U | (code >> 6U & 0x3FU));
    push(0x80U | (code & 0x3FU));
  } else {
    push(0xF0U | code >> 18U);
    push(0x80U | (code >> 12U & 0x3FU));
    push(0x80U | (code >> 6U & 0x3FU));
    push(0x80U | (code & 0x3FU));
  }
}

bool is_break(char32_t c) {
  return c == '\n' || c == 0x85 || c == 0x2028 || c == 0x2029;
}

bool is_blank_or_end(char32_t c) {
  return c == 0 || c == ' ' || c == '\t' || c == '\r' || is_break(c);
}

bool is_one_of(char32_t c, std::string_view set) {
  return c < 0x80 && set.find(static_cast<char>(c)) != std::string_view::npos;
}

/// Beyond ASCII, but shown as it is.
bool is_printable_unicode(char32_t c) {
  return c == 0x85 || (c >= 0xA0 && c <= 0xD7FF) || (c >= 0xE000 && c <= 0xFFFD && c != 0xFEFF) ||
         (c >= 0x10000 && c < 0x10FFFF);
}

/// A plain scalar that YAML 1.1 would take for something else than text.
bool reads_as_other_type(const std::string& text) {
  static const std::regex kOther(
      "|~|null|Null|NULL|<<|=|"
      "yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF|"
      R"([-+]?[0-9][0-9_]*\.[0-9_]*([eE][-+][0-9]+)?|)"
      R"(\.[0-9][0-9_]*([eE][-+][0-9]+)?|)"
      R"([-+]?[0-9][0-9_]*(:[0-5]?[0-9])+\.[0-9_]*|)"
      R"([-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)|)"
      "[-+]?0b[0-1_]+|[-+]?0[0-7_]+|[-+]?(0|[1-9][0-9_]*)|[-+]?0x[0-9a-fA-F_]+|"
      "[-+]?[1-9][0-9_]*(:[0-5]?[0-9])+|"
      R"([0-9]{4}-[0-9]{2}-[0-9]{2}|)"
      R"([0-9]{4}-[0-9]{1,2}-[0-9]{1,2}([Tt]|[ \t]+)[0-9]{1,2}:[0-9]{2}:[0-9]{2}(\.[0-9]*)?)"
      R"(([ \t]*(Z|[-+][0-9]{1,2}(:[0-9]{2})?))?)");
  constexpr std::size_t kLongestOther = 64;
  return text.size() <= kLongestOther && std::regex_match(text, kOther);
}

struct Allowed {
  bool plain = true;
  bool single_quoted = true;
};

Allowed analyze(const std::vector<char32_t>& text, bool flow) {
  bool block_indicator = false;
  bool flow_indicator = false;
  bool breaks = false;
  bool special = false;
  bool space_at_edge = false;
  bool break_then_space = false;
  bool space_then_break = false;
  const auto starts_with = [&](char32_t c) {
    return text.size() >= 3 && text[0] == c && text[1] == c && text[2] == c;
  };
  if (starts_with('-') || starts_with('.')) {
    block_indicator = flow_indicator = true;
  }
  bool after_blank = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char32_t c = text[i];
    const bool before_blank = i + 1 >= text.size() || is_blank_or_end(text[i + 1]);
    if (i == 0) {
      if (is_one_of(c, "#,[]{}&*!|>'\"%@`") || (c == '-' && before_blank)) {
        flow_indicator = block_indicator = true;
      }
      if (c == '?' || c == ':') {
        flow_indicator = true;
        block_indicator = block_indicator || before_blank;
      }
    } else {
      if (is_one_of(c, ",?[]{}:")) {
        flow_indicator = true;
      }
      if (c == ':' && before_blank) {
        block_indicator = true;
      }
      if (c == '#' && after_blank) {
        flow_indicator = block_indicator = true;
      }
    }
    breaks = breaks || is_break(c);
    special = special || !(c == '\n' || (c >= ' ' && c <= '~') || is_printable_unicode(c));
    const bool at_edge = i == 0 || i + 1 == text.size();
    space_at_edge = space_at_edge || (at_edge && (c == ' ' || is_break(c)));
    if (i > 0) {
      break_then_space = break_then_space || (c == ' ' && is_break(text[i - 1]));
      space_then_break = space_then_break || (is_break(c) && text[i - 1] == ' ');
    }
    after_blank = is_blank_or_end(c);
  }
  Allowed allowed;
  allowed.single_quoted = !(break_then_space || space_then_break || special);
  allowed.plain = allowed.single_quoted && !space_at_edge && !breaks &&
                  !(flow ? flow_indicator : block_indicator);
  return allowed;
}

std::string single_quoted(const std::vector<char32_t>& text, std::size_t indent) {
  std::string out = "'";
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!is_break(text[i])) {
      append_utf8(out, text[i]);
      if (text[i] == '\'') {
        out += '\'';
      }
      continue;
    }
    // A line break is written as an empty line: a single one would be folded into a space.
    if (text[i] == '\n') {
      out += '\n';
    }
    for (; i < text.size() && is_break(text[i]); ++i) {
      if (text[i] == '\n') {
        out += '\n';
      } else {
        append_utf8(out, text[i]);
      }
    }
    --i;
    out.append(indent, ' ');
  }
  return out + "'";
}

std::string double_quoted(const std::vector<char32_t>& text) {
  std::string out = "\"";
  const auto escape = [&](const char* format, char32_t c) {
    std::array<char, 16> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, static_cast<unsigned>(c));
    out += buffer.data();
  };
  for (const char32_t c : text) {
    switch (c) {
      case 0:
        out += "\\0";
        break;
      case 0x07:
        out += "\\a";
        break;
      case 0x08:
        out += "\\b";
        break;
      case 0x09:
        out += "\\t";
        break;
      case 0x0A:
        out += "\\n";
        break;
      case 0x0B:
        out += "\\v";
        break;
      case 0x0C:
        out += "\\f";
        break;
      case 0x0D:
        out += "\\r";
        break;
      case 0x1B:
        out += "\\e";
        break;
      case '"':
        out += "\\\"";
        break;
      case '\\':
        out += "\\\\";
        break;
      case 0x85:
        out += "\\N";
        break;
      case 0x2028:
        out += "\\L";
        break;
      case 0x2029:
        out += "\\P";
        break;
      default:
        if ((c >= ' ' && c <= '~') || is_printable_unicode(c)) {
          append_utf8(out, c);
        } else if (c <= 0xFF) {
          escape("\\x%02X", c);
        } else if (c <= 0xFFFF) {
          escape("\\u%04X", c);
        } else {
          escape("\\U%08X", c);
        }
    }
  }
  return out + "\"";
}

}  // namespace

std::string yaml_text(std::string_view text, bool flow, std::size_t indent) {
  const auto decoded = decode_utf8(text);
  const auto allowed = analyze(decoded, flow);
  if (allowed.plain && !reads_as_other_type(std::string(text))) {
    std::string out;
    for (const char32_t c : decoded) {
      append_utf8(out, c);
    }
    return out;
  }
  return allowed.single_quoted ? single_quoted(decoded, indent) : double_quoted(decoded);
}

}  // namespace pipescout::host
