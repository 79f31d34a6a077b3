// SPDX-License-Identifier: Apache-2.0
#include "keyboard.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace pipescout::bag_command {
namespace {

std::optional<Key> key_of(std::string_view text) {
  if (text == " ") {
    return Key::kSpace;
  }
  if (text == "\x1b[C") {
    return Key::kRight;
  }
  if (text == "\x1b[A") {
    return Key::kUp;
  }
  if (text == "\x1b[B") {
    return Key::kDown;
  }
  return std::nullopt;
}

}  // namespace

Keyboard::Keyboard(int terminal, std::function<void(Key)> pressed)
    : terminal_(terminal), pressed_(std::move(pressed)) {
  if (tcgetattr(terminal_, &before_) != 0) {
    throw std::system_error(errno, std::generic_category(), "the terminal's settings");
  }
  stop_ = eventfd(0, EFD_CLOEXEC);
  if (stop_ < 0) {
    throw std::system_error(errno, std::generic_category(), "eventfd");
  }
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  tcsetattr(terminal_, TCSANOW, &raw);
  thread_ = std::thread([this] { run(); });
}

Keyboard::~Keyboard() {
  const std::uint64_t one = 1;
  static_cast<void>(write(stop_, &one, sizeof one));
  thread_.join();
  close(stop_);
  tcsetattr(terminal_, TCSANOW, &before_);
}

void Keyboard::run() {
  std::array<pollfd, 2> watched{pollfd{terminal_, POLLIN, 0}, pollfd{stop_, POLLIN, 0}};
  for (;;) {
    if (poll(watched.data(), watched.size(), -1) < 0 && errno != EINTR) {
      return;
    }
    if (watched[1].revents != 0) {
      return;
    }
    if (watched[0].revents == 0) {
      continue;
    }
    // A key comes as one read, those of the arrows as three bytes.
    std::array<char, 16> bytes{};
    const auto size = read(terminal_, bytes.data(), bytes.size());
    if (size <= 0) {
      return;
    }
    if (const auto key = key_of({bytes.data(), static_cast<std::size_t>(size)})) {
      pressed_(*key);
    }
  }
}

}  // namespace pipescout::bag_command
