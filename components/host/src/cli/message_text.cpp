// SPDX-License-Identifier: Apache-2.0
#include "cli/message_text.hpp"

#include <cmath>
#include <functional>

#include "pipescout/runtime/parameter_value.hpp"

namespace pipescout::host {
namespace {

/// IDL knows no empty struct; ROS does not show the member that stands in for nothing.
constexpr std::string_view kPlaceholder = "structure_needs_at_least_one_member";

std::string yaml_number(double value) {
  if (std::isnan(value)) {
    return ".nan";
  }
  if (std::isinf(value)) {
    return value > 0 ? ".inf" : "-.inf";
  }
  auto text = to_string(ParameterValue(value));
  // "1e-07" would be a text in YAML 1.1.
  if (const auto exponent = text.find('e');
      exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

std::string element_type(const FieldDescription& field) {
  return field.kind == FieldKind::kMessage ? field.message->name
                                           : std::string(to_string(field.kind));
}

/// What stands for an array that is not shown.
std::string array_summary(const FieldDescription& field, std::size_t size) {
  const auto type = element_type(field);
  if (field.shape == FieldShape::kArray) {
    return "<array type: " + type + "[" + std::to_string(field.length) + "]>";
  }
  const auto bound = field.length != 0 ? "[" + std::to_string(field.length) + "]" : "";
  return "<sequence type: " + type + bound + ", length: " + std::to_string(size) + ">";
}

std::string string_summary(const std::string& text) {
  return "<string length: <" + std::to_string(text.size()) + ">>";
}

std::string truncated(const std::string& text, const MessageFormat& format) {
  if (!format.truncate) {
    return text;
  }
  // Counts characters: a cut inside of one would leave no valid text.
  std::size_t characters = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U;
    if (begins && characters++ == *format.truncate) {
      return text.substr(0, i) + "...";
    }
  }
  return text;
}

/// A ROS byte is shown as the character of that number.
std::string byte_text(const ScalarValue& value) {
  const auto byte = std::get<std::uint64_t>(value);
  std::string text;
  if (byte < 0x80) {
    text += static_cast<char>(byte);
  } else {
    text += static_cast<char>(0xC0U | byte >> 6U);
    text += static_cast<char>(0x80U | (byte & 0x3FU));
  }
  return text;
}

std::size_t count_of(const DynamicValue& value) {
  if (const auto* numbers = std::get_if<PrimitiveArray>(&value)) {
    return numbers->size();
  }
  if (const auto* texts = std::get_if<std::vector<std::string>>(&value)) {
    return texts->size();
  }
  return std::get<std::vector<DynamicMessage>>(value).size();
}

bool is_empty_message(const DynamicMessage& message) {
  return message.type->fields.size() == 1 && message.type->fields[0].name == kPlaceholder;
}

class YamlWriter {
 public:
  explicit YamlWriter(const MessageFormat& format) : format_(format) {}

  /// The fields as lines, each `indent` deep; the first without indentation when `inline_first`.
  void fields(const DynamicMessage& message, std::size_t indent, bool inline_first) {
    for (std::size_t i = 0; i < message.values.size(); ++i) {
      if (i > 0 || !inline_first) {
        out_.append(indent, ' ');
      }
      const auto& field = message.type->fields[i];
      out_ += field.name + ":";
      value(field, message.values[i], indent);
    }
  }

  void flow_message(const DynamicMessage& message) {
    ++flow_depth_;
    out_ += '{';
    for (std::size_t i = 0; i < message.values.size() && !is_empty_message(message); ++i) {
      out_ += (i > 0 ? ", " : "") + message.type->fields[i].name + ": ";
      flow_value(message.type->fields[i], message.values[i]);
    }
    out_ += '}';
    --flow_depth_;
  }

  void flow_value(const FieldDescription& field, const DynamicValue& value) {
    if (field.shape == FieldShape::kSingle) {
      if (const auto* nested = std::get_if<std::shared_ptr<const DynamicMessage>>(&value)) {
        flow_message(**nested);
      } else {
        out_ += single(field, value, true, flow_indent());
      }
      return;
    }
    if (format_.no_arrays) {
      out_ += yaml_text(array_summary(field, count_of(value)), true, 0);
      return;
    }
    ++flow_depth_;
    out_ += '[';
    const char* separator = "";
    for_each_element(
        field, value, true, flow_indent(),
        [&](const std::string& text) {
          out_ += separator + text;
          separator = ", ";
        },
        [&](const DynamicMessage& message) {
          out_ += separator;
          separator = ", ";
          flow_message(message);
        });
    out_ += ']';
    --flow_depth_;
  }

  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  void value(const FieldDescription& field, const DynamicValue& value, std::size_t indent) {
    constexpr std::size_t kStep = 2;
    if (field.shape == FieldShape::kSingle) {
      if (const auto* nested = std::get_if<std::shared_ptr<const DynamicMessage>>(&value)) {
        if (is_empty_message(**nested)) {
          out_ += " {}\n";
        } else {
          out_ += '\n';
          fields(**nested, indent + kStep, false);
        }
      } else {
        out_ += " " + single(field, value, false, indent + kStep) + "\n";
      }
      return;
    }
    if (format_.no_arrays) {
      out_ += " " + yaml_text(array_summary(field, count_of(value)), false, indent + kStep) + "\n";
      return;
    }
    if (count_of(value) == 0) {
      out_ += " []\n";
      return;
    }
    out_ += '\n';
    for_each_element(
        field, value, false, indent + kStep,
        [&](const std::string& text) { out_.append(indent, ' ').append("- " + text + "\n"); },
        [&](const DynamicMessage& message) {
          out_.append(indent, ' ').append("- ");
          if (is_empty_message(message)) {
            out_ += "{}\n";
          } else {
            fields(message, indent + kStep, true);
          }
        });
  }

  [[nodiscard]] std::string string(const std::string& text, bool flow, std::size_t indent) const {
    return yaml_text(format_.no_strings ? string_summary(text) : truncated(text, format_), flow,
                     indent);
  }

  [[nodiscard]] static std::string scalar(FieldKind kind, const ScalarValue& value, bool flow) {
    if (kind == FieldKind::kOctet) {
      return yaml_text(byte_text(value), flow, 0);
    }
    struct Visitor {
      std::string operator()(bool v) const { return v ? "true" : "false"; }
      std::string operator()(std::int64_t v) const { return std::to_string(v); }
      std::string operator()(std::uint64_t v) const { return std::to_string(v); }
      std::string operator()(double v) const { return yaml_number(v); }
    };
    return std::visit(Visitor{}, value);
  }

  [[nodiscard]] std::string single(const FieldDescription& field, const DynamicValue& value,
                                   bool flow, std::size_t indent) const {
    if (const auto* text = std::get_if<std::string>(&value)) {
      return string(*text, flow, indent);
    }
    return scalar(field.kind, std::get<ScalarValue>(value), flow);
  }

  void for_each_element(const FieldDescription& field, const DynamicValue& value, bool flow,
                        std::size_t indent, const std::function<void(const std::string&)>& text,
                        const std::function<void(const DynamicMessage&)>& message) const {
    const auto size = count_of(value);
    const bool cut = format_.truncate && size > *format_.truncate;
    const auto shown = cut ? *format_.truncate : size;
    for (std::size_t i = 0; i < shown; ++i) {
      if (const auto* numbers = std::get_if<PrimitiveArray>(&value)) {
        text(scalar(field.kind, (*numbers)[i], flow));
      } else if (const auto* texts = std::get_if<std::vector<std::string>>(&value)) {
        text(string((*texts)[i], flow, indent));
      } else {
        message(std::get<std::vector<DynamicMessage>>(value)[i]);
      }
    }
    if (cut) {
      text("'...'");
    }
  }

  /// Of the second and further lines of a text inside braces and brackets.
  [[nodiscard]] std::size_t flow_indent() const { return 2 * (flow_depth_ + 1); }

  const MessageFormat& format_;
  std::string out_;
  std::size_t flow_depth_ = 0;
};

/// As Python's str() writes it.
std::string python_text(FieldKind kind, const ScalarValue& value) {
  if (kind == FieldKind::kOctet) {
    return to_string(ParameterValue(
        std::vector<std::uint8_t>{static_cast<std::uint8_t>(std::get<std::uint64_t>(value))}));
  }
  struct Visitor {
    std::string operator()(bool v) const { return v ? "True" : "False"; }
    std::string operator()(std::int64_t v) const { return std::to_string(v); }
    std::string operator()(std::uint64_t v) const { return std::to_string(v); }
    std::string operator()(double v) const { return to_string(ParameterValue(v)); }
  };
  return std::visit(Visitor{}, value);
}

void append_csv(std::string& out, const DynamicMessage& message, const MessageFormat& format);

void append_csv(std::string& out, const FieldDescription& field, const DynamicValue& value,
                const MessageFormat& format) {
  const auto separate = [&out] {
    if (!out.empty()) {
      out += ',';
    }
  };
  if (field.shape == FieldShape::kSingle) {
    if (const auto* nested = std::get_if<std::shared_ptr<const DynamicMessage>>(&value)) {
      append_csv(out, **nested, format);
    } else if (const auto* text = std::get_if<std::string>(&value)) {
      separate();
      out += format.no_strings ? string_summary(*text) : truncated(*text, format);
    } else {
      separate();
      out += python_text(field.kind, std::get<ScalarValue>(value));
    }
    return;
  }
  const auto size = count_of(value);
  if (format.no_arrays) {
    separate();
    out += array_summary(field, size);
    return;
  }
  const auto shown = std::min(size, format.truncate.value_or(size));
  for (std::size_t i = 0; i < shown; ++i) {
    if (const auto* numbers = std::get_if<PrimitiveArray>(&value)) {
      separate();
      out += python_text(field.kind, (*numbers)[i]);
    } else if (const auto* texts = std::get_if<std::vector<std::string>>(&value)) {
      separate();
      out += format.no_strings ? string_summary((*texts)[i]) : truncated((*texts)[i], format);
    } else {
      append_csv(out, std::get<std::vector<DynamicMessage>>(value)[i], format);
    }
  }
  if (shown < size) {
    separate();
    out += "...";
  }
}

void append_csv(std::string& out, const DynamicMessage& message, const MessageFormat& format) {
  for (std::size_t i = 0; i < message.values.size() && !is_empty_message(message); ++i) {
    append_csv(out, message.type->fields[i], message.values[i], format);
  }
}

}  // namespace

std::string to_yaml(const DynamicMessage& message, const MessageFormat& format) {
  YamlWriter writer(format);
  if (is_empty_message(message)) {
    return "{}\n";
  }
  if (format.flow) {
    writer.flow_message(message);
    return writer.take() + "\n";
  }
  writer.fields(message, 0, false);
  return writer.take();
}

std::string to_csv(const DynamicMessage& message, const MessageFormat& format) {
  std::string out;
  append_csv(out, message, format);
  return out;
}

std::string to_text(const FieldReference& field, const MessageFormat& format) {
  if (const auto* nested = std::get_if<std::shared_ptr<const DynamicMessage>>(field.value)) {
    return to_yaml(**nested, format);
  }
  if (field.field->shape != FieldShape::kSingle) {
    YamlWriter writer(format);
    writer.flow_value(*field.field, *field.value);
    return writer.take() + "\n";
  }
  if (const auto* text = std::get_if<std::string>(field.value)) {
    return *text + "\n";
  }
  return python_text(field.field->kind, std::get<ScalarValue>(*field.value)) + "\n";
}

}  // namespace pipescout::host
