// SPDX-License-Identifier: Apache-2.0
#include "urdf_text.hpp"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <mutex>
#include <stdexcept>
#include <string>

namespace pipescout::manipulation::internal {
namespace {

/// Keeps what the parser says is wrong. It would print it, and tells its caller nothing.
class FirstError : public console_bridge::OutputHandler {
 public:
  FirstError() : lock_(mutex()) { console_bridge::useOutputHandler(this); }
  ~FirstError() override { console_bridge::restorePreviousOutputHandler(); }
  FirstError(const FirstError&) = delete;
  FirstError& operator=(const FirstError&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && text_.empty()) {
      text_ = text;
    }
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  static std::mutex& mutex() {
    static std::mutex one;  // the handler is one for the whole process
    return one;
  }
  std::lock_guard<std::mutex> lock_;
  std::string text_;
};

}  // namespace

urdf::ModelInterfaceSharedPtr parse_urdf(std::string_view text) {
  const FirstError error;
  urdf::ModelInterfaceSharedPtr robot;
  try {
    robot = urdf::parseURDF(std::string(text));
  } catch (const std::exception& exception) {
    throw std::invalid_argument(std::string("urdf: ") + exception.what());
  }
  if (!robot) {
    throw std::invalid_argument("urdf: " +
                                (error.text().empty() ? "is no robot description" : error.text()));
  }
  return robot;
}

}  // namespace pipescout::manipulation::internal
