// SPDX-License-Identifier: Apache-2.0
#include "cli/message_text.hpp"

#include <algorithm>
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

std::string element_type(const MessageField& field) {
  return std::string(field.kind == FieldKind::kMessage ? field.message().name
                                                       : to_string(field.kind));
}

/// What stands for an array that is not shown.
std::string array_summary(const FieldView& view) {
  const auto& field = view.field();
  const auto type = element_type(field);
  if (field.shape == FieldShape::kArray) {
    return "<array type: " + type + "[" + std::to_string(field.length) + "]>";
  }
  const auto bound = field.length != 0 ? "[" + std::to_string(field.length) + "]" : "";
  return "<sequence type: " + type + bound + ", length: " + std::to_string(view.size()) + ">";
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

bool is_text(FieldKind kind) {
  return kind == FieldKind::kString || kind == FieldKind::kWString;
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

bool is_empty_message(MessageView message) {
  return message.type->fields.size() == 1 && message.type->fields[0].name == kPlaceholder;
}

class YamlWriter {
 public:
  explicit YamlWriter(const MessageFormat& format) : format_(format) {}

  /// The fields as lines, each `indent` deep; the first without indentation when `inline_first`.
  void fields(MessageView message, std::size_t indent, bool inline_first) {
    bool first = true;
    for (const auto& field : message.type->fields) {
      if (!first || !inline_first) {
        out_.append(indent, ' ');
      }
      first = false;
      out_.append(field.name) += ':';
      value({field, message.message}, indent);
    }
  }

  void flow_message(MessageView message) {
    ++flow_depth_;
    out_ += '{';
    if (!is_empty_message(message)) {
      const char* separator = "";
      for (const auto& field : message.type->fields) {
        out_.append(separator).append(field.name) += ": ";
        separator = ", ";
        flow_value({field, message.message});
      }
    }
    out_ += '}';
    --flow_depth_;
  }

  void flow_value(const FieldView& view) {
    const auto& field = view.field();
    if (field.shape == FieldShape::kSingle) {
      if (field.kind == FieldKind::kMessage) {
        flow_message(view.message());
      } else {
        out_ += single(view, 0, true, flow_indent());
      }
      return;
    }
    if (format_.no_arrays) {
      out_ += yaml_text(array_summary(view), true, 0);
      return;
    }
    ++flow_depth_;
    out_ += '[';
    const char* separator = "";
    for_each_element(
        view, true, flow_indent(),
        [&](const std::string& text) {
          out_ += separator + text;
          separator = ", ";
        },
        [&](MessageView message) {
          out_ += separator;
          separator = ", ";
          flow_message(message);
        });
    out_ += ']';
    --flow_depth_;
  }

  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  void value(const FieldView& view, std::size_t indent) {
    constexpr std::size_t kStep = 2;
    const auto& field = view.field();
    if (field.shape == FieldShape::kSingle) {
      if (field.kind != FieldKind::kMessage) {
        out_ += " " + single(view, 0, false, indent + kStep) + "\n";
      } else if (const auto nested = view.message(); is_empty_message(nested)) {
        out_ += " {}\n";
      } else {
        out_ += '\n';
        fields(nested, indent + kStep, false);
      }
      return;
    }
    if (format_.no_arrays) {
      out_ += " " + yaml_text(array_summary(view), false, indent + kStep) + "\n";
      return;
    }
    if (view.size() == 0) {
      out_ += " []\n";
      return;
    }
    out_ += '\n';
    for_each_element(
        view, false, indent + kStep,
        [&](const std::string& text) { out_.append(indent, ' ').append("- " + text + "\n"); },
        [&](MessageView message) {
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

  /// An element that is no message.
  [[nodiscard]] std::string single(const FieldView& view, std::size_t index, bool flow,
                                   std::size_t indent) const {
    if (is_text(view.field().kind)) {
      return string(view.text(index), flow, indent);
    }
    return scalar(view.field().kind, view.scalar(index), flow);
  }

  void for_each_element(const FieldView& view, bool flow, std::size_t indent,
                        const std::function<void(const std::string&)>& text,
                        const std::function<void(MessageView)>& message) const {
    const auto size = view.size();
    const bool cut = format_.truncate && size > *format_.truncate;
    const auto shown = cut ? *format_.truncate : size;
    for (std::size_t i = 0; i < shown; ++i) {
      if (view.field().kind == FieldKind::kMessage) {
        message(view.message(i));
      } else {
        text(single(view, i, flow, indent));
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

void append_csv(std::string& out, MessageView message, const MessageFormat& format);

void append_csv(std::string& out, const FieldView& view, const MessageFormat& format) {
  const auto append = [&out](const std::string& text) {
    if (!out.empty()) {
      out += ',';
    }
    out += text;
  };
  const auto& field = view.field();
  if (field.shape != FieldShape::kSingle && format.no_arrays) {
    append(array_summary(view));
    return;
  }
  const auto size = view.size();
  const auto shown =
      field.shape == FieldShape::kSingle ? 1 : std::min(size, format.truncate.value_or(size));
  for (std::size_t i = 0; i < shown; ++i) {
    if (field.kind == FieldKind::kMessage) {
      append_csv(out, view.message(i), format);
    } else if (is_text(field.kind)) {
      const auto text = view.text(i);
      append(format.no_strings ? string_summary(text) : truncated(text, format));
    } else {
      append(python_text(field.kind, view.scalar(i)));
    }
  }
  if (shown < size) {
    append("...");
  }
}

void append_csv(std::string& out, MessageView message, const MessageFormat& format) {
  if (is_empty_message(message)) {
    return;
  }
  for (const auto& field : message.type->fields) {
    append_csv(out, {field, message.message}, format);
  }
}

}  // namespace

std::string to_yaml(MessageView message, const MessageFormat& format) {
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

std::string to_csv(MessageView message, const MessageFormat& format) {
  std::string out;
  append_csv(out, message, format);
  return out;
}

std::string to_text(const FieldView& view, const MessageFormat& format) {
  const auto& field = view.field();
  if (field.shape != FieldShape::kSingle) {
    YamlWriter writer(format);
    writer.flow_value(view);
    return writer.take() + "\n";
  }
  if (field.kind == FieldKind::kMessage) {
    return to_yaml(view.message(), format);
  }
  if (is_text(field.kind)) {
    return view.text() + "\n";
  }
  return python_text(field.kind, view.scalar()) + "\n";
}

}  // namespace pipescout::host
