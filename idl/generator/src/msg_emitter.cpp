// SPDX-License-Identifier: Apache-2.0
#include "msg_emitter.hpp"

#include "names.hpp"
#include "type_text.hpp"
#include "values.hpp"

namespace pipescout::generator {
namespace {

std::string quoted(const std::string& text) {
  // Whichever quotes need no escape.
  const char quote = text.find('"') == std::string::npos ? '"' : '\'';
  std::string result(1, quote);
  for (const char c : text) {
    if (c == quote || c == '\\') {
      result += '\\';
    }
    result += c;
  }
  return result + quote;
}

class MsgWriter {
 public:
  explicit MsgWriter(const Structure& structure)
      : structure_(structure), package_(split_name(structure.name).package) {}

  std::string run() {
    comments(structure_.comments);
    for (const auto& constant : structure_.constants) {
      comments(constant.comments.above);
      line(
          msg_type(constant.type, package_) + " " + constant.name + "=" + msg_value(constant.value),
          constant.comments.trailing, "");
    }
    if (!is_empty(structure_)) {
      if (!structure_.constants.empty()) {
        out_ += '\n';
      }
      for (const auto& field : structure_.fields) {
        comments(field.comments.above);
        line(msg_type(field.type, package_) + " " + field.name +
                 (field.default_value ? " " + msg_default(field) : ""),
             field.comments.trailing, field.unit);
      }
    }
    comments(structure_.closing_comments);
    return std::move(out_);
  }

 private:
  void comments(const std::vector<std::string>& lines) {
    for (const auto& text : lines) {
      out_ += text.empty() ? "#\n" : "# " + text + "\n";
    }
  }

  void line(const std::string& declaration, const std::string& comment, const std::string& unit) {
    out_ += declaration;
    if (!comment.empty() || !unit.empty()) {
      out_ += "  # " + comment + (comment.empty() || unit.empty() ? "" : " ") +
              (unit.empty() ? "" : "[" + unit + "]");
    }
    out_ += '\n';
  }

  const Structure& structure_;
  std::string package_;
  std::string out_;
};

}  // namespace

std::string msg_value(const Value& value) {
  if (const auto* const text = std::get_if<std::string>(&value)) {
    return quoted(*text);
  }
  return number_text(value);
}

std::string msg_default(const Field& field) {
  if (field.type.shape == Shape::kSingle) {
    return msg_value(field.default_value->front());
  }
  std::string list;
  for (const auto& value : *field.default_value) {
    list += (list.empty() ? "" : ", ") + msg_value(value);
  }
  return "[" + list + "]";
}

std::string msg_text(const Structure& structure) {
  return MsgWriter(structure).run();
}

std::string msg_text(const Interface& interface) {
  // Behind the parts that a file holds come those that ROS 2 derives from an action.
  const std::size_t parts = interface.kind == InterfaceKind::kMessage   ? 1
                            : interface.kind == InterfaceKind::kService ? 2
                                                                        : 3;
  std::string text;
  for (std::size_t i = 0; i < parts; ++i) {
    text += (i > 0 ? "---\n" : "") + msg_text(interface.structures[i]);
  }
  return text;
}

}  // namespace pipescout::generator
