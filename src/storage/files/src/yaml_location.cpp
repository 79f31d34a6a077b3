// SPDX-License-Identifier: Apache-2.0
#include "pipescout/files/yaml_location.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

namespace pipescout {
namespace {

constexpr int kMaxNesting = 64;

std::string prefix(const std::string& path, int line, int column) {
  if (line <= 0) {
    return path;
  }
  return path + ":" + std::to_string(line) + ":" + std::to_string(column);
}

// Marks count from 0, and are -1 where there is no position.
int line_of(const YAML::Mark& mark) {
  return mark.is_null() ? 0 : mark.line + 1;
}
int column_of(const YAML::Mark& mark) {
  return mark.is_null() ? 0 : mark.column + 1;
}

// yaml-cpp takes a NUL or an end-of-transmission character for the end of the file and would
// silently ignore what follows.
void check_characters(const std::string& text, const std::string& path) {
  int line = 1;
  int column = 1;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte < 0x20 && c != '\n' && c != '\t' && c != '\r') || byte == 0x7f) {
      throw YamlError(path, line, column,
                      "control character " + std::to_string(byte) + "; the file is not UTF-8 text");
    }
    if (c == '\n') {
      ++line;
      column = 1;
    } else {
      ++column;
    }
  }
}

// Looks at the events of a document before any node is built from them.
class Gatekeeper : public YAML::EventHandler {
 public:
  explicit Gatekeeper(const std::string& path) : path_(path) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) {
      refuse(mark, "a second document; one file holds one");
    }
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    refuse(mark, "aliases are not supported; write the value again");
  }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    descend(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    descend(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  [[noreturn]] void refuse(const YAML::Mark& mark, const std::string& message) const {
    throw YamlError(path_, mark, message);
  }
  void descend(const YAML::Mark& mark) {
    if (++depth_ > kMaxNesting) {
      refuse(mark, "nested more than " + std::to_string(kMaxNesting) + " levels deep");
    }
  }

  const std::string& path_;
  int documents_ = 0;
  int depth_ = 0;
};

// Depth is bounded by the gatekeeper.
void check_keys(const YAML::Node& node, const std::string& path) {
  if (node.IsSequence()) {
    for (const auto& element : node) {
      check_keys(element, path);
    }
  } else if (node.IsMap()) {
    std::map<std::string, int> seen;
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) {
        throw YamlError(path, entry.first.Mark(), "a key must be a plain name");
      }
      const auto [first, is_new] = seen.emplace(entry.first.Scalar(), line_of(entry.first.Mark()));
      if (!is_new) {
        throw YamlError(path, entry.first.Mark(),
                        "duplicate key '" + entry.first.Scalar() + "', first given in line " +
                            std::to_string(first->second));
      }
      check_keys(entry.second, path);
    }
  }
}

}  // namespace

YamlError::YamlError(std::string path, int line, int column, const std::string& message)
    : std::runtime_error(prefix(path, line, column) + ": " + message),
      path_(std::move(path)),
      line_(line),
      column_(column) {}

YamlError::YamlError(std::string path, const YAML::Mark& mark, const std::string& message)
    : YamlError(std::move(path), line_of(mark), column_of(mark), message) {}

std::string location(const std::string& path, const YAML::Mark& mark) {
  return prefix(path, line_of(mark), column_of(mark));
}

std::string line_location(const std::string& path, const YAML::Mark& mark) {
  return mark.is_null() ? path : path + ":" + std::to_string(line_of(mark));
}

YAML::Node parse_yaml(const std::string& text, const std::string& path) {
  check_characters(text, path);
  try {
    // yaml-cpp accepts a quoted string that is never closed when the text ends with a newline; not
    // so when a character follows. In all other places that character begins a comment.
    std::istringstream stream(text + "\n#");
    YAML::Parser parser(stream);
    Gatekeeper gatekeeper(path);
    while (parser.HandleNextDocument(gatekeeper)) {
    }
    const YAML::Node root = YAML::Load(text);
    check_keys(root, path);
    return root;
  } catch (const YAML::Exception& error) {
    throw YamlError(path, error.mark, error.msg);
  }
}

YAML::Node load_yaml(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  // A folder opens, but does not read.
  if (!file || !(text << file.rdbuf())) {
    const bool is_empty = file && file.peek() == std::ifstream::traits_type::eof() && errno == 0;
    if (!is_empty) {
      throw YamlError(
          path, 0, 0,
          std::string("cannot be read: ") + (errno != 0 ? std::strerror(errno) : "input error"));
    }
  }
  return parse_yaml(text.str(), path);
}

}  // namespace pipescout
