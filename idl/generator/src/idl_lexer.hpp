// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pipescout::generator {

struct IdlToken {
  enum class Kind : std::uint8_t { kWord, kNumber, kString, kPunctuation, kInclude, kEnd };
  Kind kind = Kind::kEnd;
  std::string text;  ///< strings: the content; includes: the path
  int line = 0;
};

/// One line of a comment.
struct IdlComment {
  std::string text;  ///< without the signs that mark it
  int line = 0;
  bool alone = false;  ///< nothing else stands on its line before it
};

struct IdlTokens {
  std::vector<IdlToken> tokens;  ///< the last one is kEnd
  std::vector<IdlComment> comments;
};

/// Throws DefinitionError; among other things for every preprocessor directive but #include, as
/// rosidl's grammar has it.
[[nodiscard]] IdlTokens tokenize_idl(std::string_view text, const std::string& file);

}  // namespace pipescout::generator
