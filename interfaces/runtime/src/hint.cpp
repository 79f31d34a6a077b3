// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/hint.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

namespace pipescout {
namespace {

/// Unicode characters of UTF-8; a byte that is none stands for itself.
std::vector<char32_t> characters(std::string_view text) {
  std::vector<char32_t> result;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 1;
    if (length == 1 || i + length > text.size()) {
      result.push_back(first);
      ++i;
      continue;
    }
    char32_t character = first & (0xFFU >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      character = character << 6U | (static_cast<unsigned char>(text[i + k]) & 0x3FU);
    }
    result.push_back(character);
    i += length;
  }
  return result;
}

/// The ASCII character that one looks like, 0 for one that is not seen.
char32_t looks_like(char32_t character) {
  // Letters of Cyrillic and Greek, as in Unicode's list of confusable characters; names are lower
  // case as a rule, so that upper case letters have only what differs by font.
  constexpr std::array<std::pair<char32_t, char32_t>, 24> kLetters{
      {{U'а', U'a'}, {U'с', U'c'}, {U'ԁ', U'd'}, {U'е', U'e'}, {U'һ', U'h'}, {U'і', U'l'},
       {U'ј', U'j'}, {U'о', U'o'}, {U'р', U'p'}, {U'ѕ', U's'}, {U'х', U'x'}, {U'у', U'y'},
       {U'ο', U'o'}, {U'ν', U'v'}, {U'α', U'a'}, {U'ι', U'l'}, {U'ρ', U'p'}, {U'I', U'l'},
       {U'1', U'l'}, {U'|', U'l'}, {U'0', U'o'}, {U'O', U'o'}, {U'i', U'l'}, {U'‐', U'-'}}};
  const auto* const letter =
      std::find_if(kLetters.begin(), kLetters.end(),
                   [character](const auto& entry) { return entry.first == character; });
  if (letter != kLetters.end()) {
    return letter->second;
  }
  const bool unseen = character <= U' ' || character == 0x7F || character == 0xA0 ||
                      character == 0xAD || (character >= 0x2000 && character <= 0x200F) ||
                      character == 0xFEFF;
  return unseen ? 0 : character;
}

std::vector<char32_t> appearance(std::vector<char32_t> text) {
  std::transform(text.begin(), text.end(), text.begin(), looks_like);
  std::erase(text, U'\0');
  return text;
}

std::string description(const std::vector<char32_t>& text, std::size_t index) {
  if (index >= text.size()) {
    return "nothing";
  }
  std::array<char, 16> code{};
  std::snprintf(code.data(), code.size(), "U+%04X", static_cast<unsigned>(text[index]));
  const bool ascii = text[index] > U' ' && text[index] < 0x7F;
  return ascii ? std::string("'") + static_cast<char>(text[index]) + "' (" + code.data() + ")"
               : std::string(code.data());
}

}  // namespace

std::string did_you_mean(std::string_view given, std::string_view nearest) {
  std::string text = "; did you mean '" + std::string(nearest) + "'?";
  const auto left = characters(given);
  const auto right = characters(nearest);
  if (left == right || appearance(left) != appearance(right)) {
    return text;
  }
  const auto at = static_cast<std::size_t>(
      std::mismatch(left.begin(), left.end(), right.begin(), right.end()).first - left.begin());
  return text + " Its character " + std::to_string(at + 1) + " is " + description(right, at) +
         ", yours is " + description(left, at) + ".";
}

}  // namespace pipescout
