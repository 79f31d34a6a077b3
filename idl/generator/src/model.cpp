// SPDX-License-Identifier: Apache-2.0
#include "model.hpp"

namespace pipescout::generator {

std::size_t size_of(Kind kind) noexcept {
  switch (kind) {
    case Kind::kBool:
    case Kind::kOctet:
    case Kind::kChar:
    case Kind::kInt8:
    case Kind::kUInt8:
      return 1;
    case Kind::kInt16:
    case Kind::kUInt16:
      return 2;
    case Kind::kInt32:
    case Kind::kUInt32:
    case Kind::kFloat32:
      return 4;
    case Kind::kInt64:
    case Kind::kUInt64:
    case Kind::kFloat64:
      return 8;
    case Kind::kString:
    case Kind::kWString:
    case Kind::kMessage:
      return 0;
  }
  return 0;
}

bool is_text(Kind kind) noexcept {
  return kind == Kind::kString || kind == Kind::kWString;
}

bool is_signed(Kind kind) noexcept {
  return kind == Kind::kInt8 || kind == Kind::kInt16 || kind == Kind::kInt32 ||
         kind == Kind::kInt64;
}

bool is_floating_point(Kind kind) noexcept {
  return kind == Kind::kFloat32 || kind == Kind::kFloat64;
}

bool is_empty(const Structure& structure) {
  return structure.fields.size() == 1 && structure.fields[0].name == kPlaceholder;
}

}  // namespace pipescout::generator
