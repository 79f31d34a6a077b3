// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "pipescout/runtime/introspection.hpp"

namespace pipescout {
namespace {

template <class T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

ScalarValue load_scalar(FieldKind kind, const std::byte* from) {
  switch (kind) {
    case FieldKind::kBool:
      return std::to_integer<unsigned>(*from) != 0;
    case FieldKind::kInt8:
      return std::int64_t{load<std::int8_t>(from)};
    case FieldKind::kInt16:
      return std::int64_t{load<std::int16_t>(from)};
    case FieldKind::kInt32:
      return std::int64_t{load<std::int32_t>(from)};
    case FieldKind::kInt64:
      return load<std::int64_t>(from);
    case FieldKind::kUInt16:
      return std::uint64_t{load<std::uint16_t>(from)};
    case FieldKind::kUInt32:
      return std::uint64_t{load<std::uint32_t>(from)};
    case FieldKind::kUInt64:
      return load<std::uint64_t>(from);
    case FieldKind::kFloat32:
      return double{load<float>(from)};
    case FieldKind::kFloat64:
      return load<double>(from);
    default:
      return std::uint64_t{load<std::uint8_t>(from)};
  }
}

/// The path to the field being read, for messages; kept as a chain so that nothing is built unless
/// an error needs it.
struct Path {
  const Path* parent;
  std::string_view name;

  [[nodiscard]] std::string text() const {
    std::string text = parent != nullptr ? parent->text() : std::string();
    if (!text.empty()) {
      text += '.';
    }
    return text.append(name);
  }
};

/// Reads plain CDR (XCDR version 1): each primitive is aligned to its size, counted from behind the
/// encapsulation header.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> cdr) : cdr_(cdr) {
    if (cdr.size() < kHeader) {
      throw MalformedMessage("no encapsulation header: " + std::to_string(cdr.size()) + " bytes");
    }
    const auto id = std::to_integer<unsigned>(cdr[0]) << 8U | std::to_integer<unsigned>(cdr[1]);
    constexpr unsigned kBigEndian = 0;
    constexpr unsigned kLittleEndian = 1;
    if (id != kBigEndian && id != kLittleEndian) {
      throw MalformedMessage("encapsulation " + std::to_string(id) + " is not plain CDR");
    }
    swap_ = (id == kLittleEndian) != (std::endian::native == std::endian::little);
  }

  DynamicMessage message(const std::shared_ptr<const MessageDescription>& type,
                         const Path* parent) {
    DynamicMessage result{type, {}};
    result.values.reserve(type->fields.size());
    for (const auto& field : type->fields) {
      result.values.push_back(value(field, Path{parent, field.name}));
    }
    return result;
  }

 private:
  static constexpr std::size_t kHeader = 4;

  [[nodiscard]] std::size_t remaining() const { return cdr_.size() - position_; }

  [[noreturn]] void fail(const Path& path, const std::string& what) const {
    throw MalformedMessage(path.text() + ": " + what + " at byte " + std::to_string(position_) +
                           ", " + std::to_string(remaining()) + " bytes are left");
  }

  void align(std::size_t size, const Path& path) {
    const auto padding = (size - (position_ - kHeader) % size) % size;
    if (padding > remaining()) {
      fail(path, "padding");
    }
    position_ += padding;
  }

  /// `count` elements of `kind`, in native byte order.
  std::vector<std::byte> elements(FieldKind kind, std::size_t count, const Path& path) {
    const auto size = size_of(kind);
    if (count == 0) {
      return {};
    }
    align(size, path);
    if (count > remaining() / size) {
      fail(path, std::to_string(count) + " x " + std::string(to_string(kind)));
    }
    const auto source = cdr_.subspan(position_, count * size);
    position_ += source.size();
    std::vector<std::byte> bytes(source.begin(), source.end());
    if (swap_ && size > 1) {
      for (auto element = bytes.begin(); element != bytes.end();
           element += static_cast<std::ptrdiff_t>(size)) {
        std::reverse(element, element + static_cast<std::ptrdiff_t>(size));
      }
    }
    return bytes;
  }

  ScalarValue scalar(FieldKind kind, const Path& path) {
    const auto size = size_of(kind);
    align(size, path);
    if (size > remaining()) {
      fail(path, std::string(to_string(kind)));
    }
    std::array<std::byte, 8> bytes{};
    std::copy_n(cdr_.begin() + static_cast<std::ptrdiff_t>(position_), size, bytes.begin());
    position_ += size;
    if (swap_) {
      std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    }
    return load_scalar(kind, bytes.data());
  }

  std::uint32_t length(const Path& path) {
    return static_cast<std::uint32_t>(std::get<std::uint64_t>(scalar(FieldKind::kUInt32, path)));
  }

  std::string string(std::size_t bound, const Path& path) {
    const std::size_t size = length(path);
    if (size > remaining()) {
      fail(path, "string of " + std::to_string(size) + " bytes");
    }
    const auto* first = reinterpret_cast<const char*>(cdr_.data() + position_);
    position_ += size;
    // The length counts the terminating NUL; some writers send 0 for an empty string.
    std::string text(first, size == 0 ? 0 : size - 1);
    if (size != 0 && first[size - 1] != '\0') {
      fail(path, "string without its terminating NUL");
    }
    if (bound != 0 && text.size() > bound) {
      fail(path, "string longer than its bound of " + std::to_string(bound));
    }
    return text;
  }

  DynamicValue value(const FieldDescription& field, const Path& path) {
    if (field.shape == FieldShape::kSingle) {
      switch (field.kind) {
        case FieldKind::kString:
          return string(field.string_length, path);
        case FieldKind::kMessage:
          return std::make_shared<const DynamicMessage>(message(field.message, &path));
        default:
          return scalar(field.kind, path);
      }
    }
    std::size_t count = field.length;
    if (field.shape == FieldShape::kSequence) {
      count = length(path);
      if (field.length != 0 && count > field.length) {
        fail(path, std::to_string(count) + " elements exceed the bound of " +
                       std::to_string(field.length));
      }
    }
    switch (field.kind) {
      case FieldKind::kString:
        return strings(field, count, path);
      case FieldKind::kMessage:
        return messages(field, count, path);
      default:
        return PrimitiveArray(field.kind, elements(field.kind, count, path));
    }
  }

  std::vector<std::string> strings(const FieldDescription& field, std::size_t count,
                                   const Path& path) {
    constexpr std::size_t kSmallestString = 4;
    if (count > remaining() / kSmallestString) {
      fail(path, std::to_string(count) + " strings");
    }
    std::vector<std::string> result;
    result.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      result.push_back(string(field.string_length, path));
    }
    return result;
  }

  std::vector<DynamicMessage> messages(const FieldDescription& field, std::size_t count,
                                       const Path& path) {
    // Every message takes a byte at least, so a hostile count ends at the last one.
    if (count > remaining()) {
      fail(path, std::to_string(count) + " messages");
    }
    std::vector<DynamicMessage> result;
    for (std::size_t i = 0; i < count; ++i) {
      result.push_back(message(field.message, &path));
    }
    return result;
  }

  std::span<const std::byte> cdr_;
  std::size_t position_ = kHeader;
  bool swap_ = false;
};

}  // namespace

PrimitiveArray::PrimitiveArray(FieldKind kind, std::vector<std::byte> bytes)
    : kind_(kind), bytes_(std::move(bytes)) {
  if (size_of(kind) == 0 || bytes_.size() % size_of(kind) != 0) {
    throw std::invalid_argument("PrimitiveArray: " + std::to_string(bytes_.size()) +
                                " bytes are no array of " + std::string(to_string(kind)));
  }
}

ScalarValue PrimitiveArray::operator[](std::size_t index) const {
  return load_scalar(kind_, bytes_.data() + index * size_of(kind_));
}

FieldReference find_field(const DynamicMessage& message, std::string_view path) {
  const DynamicMessage* at = &message;
  for (std::size_t begin = 0;;) {
    const auto end = std::min(path.find('.', begin), path.size());
    const auto name = path.substr(begin, end - begin);
    const auto& fields = at->type->fields;
    const auto field = std::find_if(fields.begin(), fields.end(),
                                    [&](const FieldDescription& f) { return f.name == name; });
    if (field == fields.end()) {
      throw std::invalid_argument("'" + std::string(name) + "' is no field of " + at->type->name);
    }
    const auto& value = at->values[static_cast<std::size_t>(field - fields.begin())];
    if (end == path.size()) {
      return {&*field, &value};
    }
    const auto* nested = std::get_if<std::shared_ptr<const DynamicMessage>>(&value);
    if (nested == nullptr) {
      throw std::invalid_argument("'" + std::string(path.substr(0, end)) +
                                  "' is no message, so it has no field '" +
                                  std::string(path.substr(end + 1)) + "'");
    }
    at = nested->get();
    begin = end + 1;
  }
}

DynamicMessage read_message(const std::shared_ptr<const MessageDescription>& type,
                            std::span<const std::byte> cdr) {
  return CdrReader(cdr).message(type, nullptr);
}

}  // namespace pipescout
