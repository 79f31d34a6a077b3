// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Cuts an .idl file into tokens, for introspection_idl.cpp.
namespace pipescout {

struct IdlToken {
  enum class Kind {
    kWord,         ///< an identifier or keyword, with the '_' that escapes it
    kNumber,       ///< as written, without sign
    kString,       ///< the content of "..."
    kPunctuation,  ///< one character, or "::"
    kInclude,      ///< the file of an #include line
    kEnd
  };
  Kind kind = Kind::kEnd;
  std::string text;
  int line = 0;  ///< from 1
  int column = 0;
};

/// Comments are left out, and of the preprocessor's lines all but #include. The last token is kEnd.
/// `file` names the text in errors. Throws IdlError.
[[nodiscard]] std::vector<IdlToken> tokenize_idl(std::string_view text, const std::string& file);

/// Throws IdlError "file:line:column: message".
[[noreturn]] void fail_idl(const std::string& file, int line, int column,
                           const std::string& message);

}  // namespace pipescout
