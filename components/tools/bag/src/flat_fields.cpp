// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "pipescout/command_line/command.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "topic_export.hpp"

namespace pipescout::bag_command {
namespace {

std::string element_name(const MessageField& field, const std::string& prefix, std::size_t index) {
  std::string name = prefix + std::string(field.name);
  if (field.shape != FieldShape::kSingle) {
    name += "[" + std::to_string(index) + "]";
  }
  return name;
}

template <class T>
std::string shortest(T value) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string cell_of(const FieldView& view, std::size_t index) {
  const FieldKind kind = view.field().kind;
  if (kind == FieldKind::kString || kind == FieldKind::kWString) {
    return csv_cell(view.text(index));
  }
  return std::visit(
      [kind](auto value) -> std::string {
        if constexpr (std::is_same_v<decltype(value), bool>) {
          return value ? "1" : "0";
        } else if constexpr (std::is_same_v<decltype(value), double>) {
          return kind == FieldKind::kFloat32 ? shortest(static_cast<float>(value))
                                             : shortest(value);
        } else {
          return std::to_string(value);
        }
      },
      view.scalar(index));
}

}  // namespace

std::string file_name_of(std::string_view topic) {
  std::string name;
  for (const char c : topic) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-';
    name += plain ? c : '_';
  }
  name.erase(0, std::min(name.find_first_not_of('_'), name.size()));
  return name.empty() ? "topic" : name;
}

TextFile::TextFile(std::filesystem::path path) : path_(std::move(path)), file_(path_) {
  if (!file_) {
    throw command_line::CommandError(path_.string() + ": " + std::strerror(errno));
  }
}

void TextFile::write(const std::string& line) {
  if (!(file_ << line << '\n')) {
    throw command_line::CommandError(path_.string() + ": cannot be written");
  }
}

void TextFile::close() {
  file_.close();
  if (!file_) {
    throw command_line::CommandError(path_.string() + ": cannot be written");
  }
}

FlatFields::FlatFields(const MessageType& type, std::size_t limit)
    : nodes_(nodes_of(type)), limit_(limit) {}

std::vector<FlatFields::Node> FlatFields::nodes_of(const MessageType& type) {
  std::vector<Node> nodes;
  for (const MessageField& field : type.fields) {
    Node& node = nodes.emplace_back();
    node.field = &field;
    node.longest = field.shape == FieldShape::kArray    ? field.length
                   : field.shape == FieldShape::kSingle ? 1
                                                        : 0;
    if (field.kind == FieldKind::kMessage) {
      node.fields = nodes_of(field.message());
    }
  }
  return nodes;
}

void FlatFields::observe(MessageView message) {
  observe(nodes_, message);
}

void FlatFields::observe(std::vector<Node>& nodes, MessageView message) {
  for (Node& node : nodes) {
    const FieldView view(*node.field, message.message);
    node.longest = std::max(node.longest, view.size());
    if (node.field->kind == FieldKind::kMessage) {
      for (std::size_t k = 0; k < view.size(); ++k) {
        observe(node.fields, view.message(k));
      }
    }
  }
}

std::vector<std::string> FlatFields::columns() const {
  std::vector<std::string> columns;
  add_columns(nodes_, "", columns);
  return columns;
}

void FlatFields::add_columns(const std::vector<Node>& nodes, const std::string& prefix,
                             std::vector<std::string>& columns) const {
  for (const Node& node : nodes) {
    if (node.longest > limit_) {
      columns.push_back(prefix + std::string(node.field->name) + ".size");
      continue;
    }
    for (std::size_t k = 0; k < node.longest; ++k) {
      const std::string name = element_name(*node.field, prefix, k);
      if (node.field->kind == FieldKind::kMessage) {
        add_columns(node.fields, name + ".", columns);
      } else {
        columns.push_back(name);
      }
    }
  }
}

void FlatFields::cells(MessageView message, std::vector<std::string>& cells) const {
  add_cells(nodes_, message, cells);
}

void FlatFields::add_cells(const std::vector<Node>& nodes, MessageView message,
                           std::vector<std::string>& cells) const {
  for (const Node& node : nodes) {
    const bool here = message.message != nullptr;
    const std::size_t size = here ? FieldView(*node.field, message.message).size() : 0;
    if (node.longest > limit_) {
      cells.push_back(here ? std::to_string(size) : "");
      continue;
    }
    for (std::size_t k = 0; k < node.longest; ++k) {
      const bool is_message = node.field->kind == FieldKind::kMessage;
      if (k >= size && !is_message) {
        cells.emplace_back();
      } else if (k >= size) {
        add_cells(node.fields, {}, cells);
      } else if (is_message) {
        add_cells(node.fields, FieldView(*node.field, message.message).message(k), cells);
      } else {
        cells.push_back(cell_of(FieldView(*node.field, message.message), k));
      }
    }
  }
}

}  // namespace pipescout::bag_command
