// SPDX-License-Identifier: Apache-2.0
#include "cli/daemon.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string_view>
#include <system_error>
#include <utility>

namespace pipescout::host {
namespace {

/// A partner that has begun to speak does not pause for so long; a connection is on this machine.
constexpr auto kLongestPause = std::chrono::seconds(1);

// The first byte of what is asked.
constexpr char kRunCommand = 'c';
constexpr char kStop = 's';

/// What decides how a process joins the network, and so what it discovers.
constexpr std::array kDecisiveVariables{"ROS_DOMAIN_ID",
                                        "ROS_LOCALHOST_ONLY",
                                        "ROS_DISCOVERY_SERVER",
                                        "ROS_SUPER_CLIENT",
                                        "ROS_STATIC_PEERS",
                                        "PIPESCOUT_NETWORK",
                                        "ROS_SECURITY_ENABLE",
                                        "ROS_SECURITY_STRATEGY",
                                        "ROS_SECURITY_KEYSTORE",
                                        "ROS_SECURITY_ENCLAVE_OVERRIDE",
                                        "FASTRTPS_DEFAULT_PROFILES_FILE"};

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Of this executable, with these variables; the user is asked for by `is_of_this_user`.
std::string name_of_socket() {
  struct stat program {};
  if (stat("/proc/self/exe", &program) != 0) {
    fail("/proc/self/exe");
  }
  std::string identity = std::to_string(geteuid()) + ' ' + std::to_string(program.st_dev) + ' ' +
                         std::to_string(program.st_ino) + ' ' +
                         std::to_string(program.st_mtim.tv_sec) + '.' +
                         std::to_string(program.st_mtim.tv_nsec);
  for (const char* variable : kDecisiveVariables) {
    const char* const value = std::getenv(variable);
    identity += '\n' + std::string(variable) + '=' + (value == nullptr ? "" : value);
  }
  // Both ends are the same executable, and so have the same hash.
  return "pipescout daemon " + std::to_string(std::hash<std::string>()(identity));
}

/// An address of the abstract namespace, whose first byte is 0.
std::pair<sockaddr_un, socklen_t> address_of_socket() {
  const std::string name = name_of_socket();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());
  return {address, static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size())};
}

bool is_of_this_user(int connection) {
  ucred peer{};
  socklen_t size = sizeof peer;
  return getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 &&
         peer.uid == geteuid();
}

/// A connected socket, closed at the end.
class Connection {
 public:
  explicit Connection(int descriptor) : descriptor_(descriptor) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }
  /// None when no daemon listens.
  static int open_to_daemon() {
    const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (descriptor < 0) {
      fail("socket");
    }
    const auto [address, size] = address_of_socket();
    if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
        !is_of_this_user(descriptor)) {
      close(descriptor);
      return -1;
    }
    return descriptor;
  }
  explicit operator bool() const noexcept { return descriptor_ >= 0; }

  void be_patient(Duration longest_pause) const {
    timeval limit{};
    limit.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(longest_pause).count();
    setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    setsockopt(descriptor_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  }
  /// All of it, and that it is all. False when the other end has gone or does not take it.
  [[nodiscard]] bool say(std::string_view text) const {
    while (!text.empty()) {
      const auto sent = send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL);
      if (sent < 0) {
        if (errno == EINTR) {
          continue;
        }
        return false;
      }
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
    return shutdown(descriptor_, SHUT_WR) == 0;
  }
  /// Until the other end has said all; nothing when it makes too long a pause.
  [[nodiscard]] std::optional<std::string> hear() const {
    std::string text;
    std::array<char, 4096> piece{};
    while (true) {
      const auto got = recv(descriptor_, piece.data(), piece.size(), 0);
      if (got == 0) {
        return text;
      }
      if (got < 0) {
        if (errno == EINTR) {
          continue;
        }
        return std::nullopt;
      }
      text.append(piece.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  int descriptor_;
};

/// Each word and a zero behind it.
std::string packed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += word + '\0';
  }
  return text;
}

std::vector<std::string> unpacked(std::string_view text) {
  std::vector<std::string> words;
  while (!text.empty()) {
    const auto end = text.find('\0');
    words.emplace_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return words;
}

/// "CODE SIZE_OF_OUT\n", then the two texts.
std::string packed(const CommandOutput& output) {
  return std::to_string(output.code) + ' ' + std::to_string(output.out.size()) + '\n' + output.out +
         output.err;
}

/// Nothing when it is cut off.
std::optional<CommandOutput> unpacked_output(const std::string& text) {
  CommandOutput output;
  std::size_t size = 0;
  const char* const end = text.data() + text.size();
  const auto code = std::from_chars(text.data(), end, output.code);
  if (code.ec != std::errc{} || code.ptr == end) {
    return std::nullopt;
  }
  const auto out = std::from_chars(code.ptr + 1, end, size);
  if (out.ec != std::errc{} || out.ptr == end ||
      size > static_cast<std::size_t>(end - out.ptr) - 1) {
    return std::nullopt;
  }
  output.out.assign(out.ptr + 1, size);
  output.err.assign(out.ptr + 1 + size, end);
  return output;
}

}  // namespace

std::optional<int> ask_daemon(const std::vector<std::string>& words, Duration patience) {
  const Connection daemon(Connection::open_to_daemon());
  if (!daemon) {
    return std::nullopt;
  }
  daemon.be_patient(patience + kLongestPause);
  if (!daemon.say(kRunCommand + packed(words))) {
    return std::nullopt;
  }
  const auto answer = daemon.hear();
  const auto output = answer ? unpacked_output(*answer) : std::nullopt;
  if (!output) {
    return std::nullopt;
  }
  std::cerr << output->err;
  std::cout << output->out;
  return output->code;
}

bool daemon_runs() {
  return static_cast<bool>(Connection(Connection::open_to_daemon()));
}

bool stop_daemon() {
  const Connection daemon(Connection::open_to_daemon());
  if (!daemon || !daemon.say({&kStop, 1})) {
    return false;
  }
  (void)daemon.hear();  // it says nothing, and closes the connection behind its socket
  return true;
}

std::optional<DaemonSocket> DaemonSocket::claim() {
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) {
    fail("socket");
  }
  DaemonSocket claimed(descriptor);
  const auto [address, size] = address_of_socket();
  if (bind(descriptor, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    if (errno == EADDRINUSE) {
      return std::nullopt;
    }
    fail("the socket of the daemon");
  }
  if (listen(descriptor, SOMAXCONN) != 0) {
    fail("the socket of the daemon");
  }
  return claimed;
}

DaemonSocket::DaemonSocket(DaemonSocket&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

DaemonSocket::~DaemonSocket() {
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

void DaemonSocket::stop() {
  shutdown(descriptor_, SHUT_RDWR);
}

void DaemonSocket::serve(const Answer& answer, Duration idle) {
  const auto idle_milliseconds =
      static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(idle).count());
  while (true) {
    pollfd listening{descriptor_, POLLIN, 0};
    const int ready = poll(&listening, 1, idle_milliseconds);
    if (ready < 0 && errno == EINTR) {
      continue;
    }
    if (ready <= 0 || (listening.revents & POLLHUP) != 0) {
      return;
    }
    const Connection client(accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC));
    if (!client) {
      if (errno == EINTR || errno == ECONNABORTED) {
        continue;
      }
      return;
    }
    client.be_patient(kLongestPause);
    const auto asked = client.hear();
    if (!asked || asked->empty()) {
      continue;  // who only looks whether somebody is there
    }
    if (asked->front() == kStop) {
      close(std::exchange(descriptor_, -1));
      return;
    }
    (void)client.say(packed(answer(unpacked(std::string_view(*asked).substr(1)))));
  }
}

}  // namespace pipescout::host
