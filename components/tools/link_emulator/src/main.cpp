// SPDX-License-Identifier: Apache-2.0
// Loss, delay and rate between the network namespaces of robots and the rest, on any kernel: what
// sch_netem does, which not every kernel has, and one radio channel that all share. For
// launch_scripts/fleet.sh.
//
//   pipescout_link_emulator [--loss PERCENT] [--delay MS] [--rate MBIT] [--shared] HOST...
//
// Frames go from the TAP device eth0 in the namespace HOST (of "ip netns"), which the host takes
// for its network, to the interface HOST in the namespace `air`, and back. There they are out of
// reach of the host's own network stack. Prints "ready" once they do.
#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_packet.h>
#include <linux/if_tun.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <sched.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

#include "emulated_links.hpp"

namespace {

using pipescout_test::EmulatedLinks;
using pipescout_test::LinkOptions;

constexpr const char* kTap = "eth0";
constexpr const char* kAir = "air";
// A virtio_net_hdr precedes each frame on both sides, so that the kernel completes checksums that a
// sender left to its (virtual) hardware. (<linux/virtio_net.h> is not C++.)
constexpr std::size_t kHeader = 10;
constexpr std::size_t kMostBytes = 65'536 + kHeader;  // also of a frame that is split later
constexpr int kReceiveBuffer = 4 * 1024 * 1024;       // for the time that a busy machine takes
constexpr int kEvents = 64;
constexpr double kBitsPerMegabit = 1e6;
constexpr double kPercent = 100.0;
constexpr double kMostDelay = 10'000.0;  // ms
constexpr double kMostRate = 10'000.0;   // Mbit/s

/// Throws std::system_error with what was tried if the result of a system call is negative.
int checked(int result, const std::string& what) {
  if (result < 0) {
    throw std::system_error(errno, std::generic_category(), what);
  }
  return result;
}

int open_tap(const std::string& host) {
  const int tap = checked(open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC), "/dev/net/tun");
  ifreq request{};
  std::strncpy(request.ifr_name, kTap, IFNAMSIZ - 1);
  request.ifr_flags = IFF_TAP | IFF_NO_PI | IFF_VNET_HDR;
  checked(ioctl(tap, TUNSETIFF, &request), host + ": TAP device " + kTap);
  return tap;
}

int open_wire(const std::string& host) {
  const std::string what = "interface " + host + " in the namespace " + kAir;
  const int wire =
      checked(socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(ETH_P_ALL)), what);
  const int on = 1;
  checked(setsockopt(wire, SOL_PACKET, PACKET_VNET_HDR, &on, sizeof on), what);
  checked(setsockopt(wire, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on), what);
  checked(setsockopt(wire, SOL_SOCKET, SO_RCVBUFFORCE, &kReceiveBuffer, sizeof kReceiveBuffer),
          what);
  const unsigned index = if_nametoindex(host.c_str());
  checked(index == 0 ? -1 : 0, what);
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(index);
  checked(bind(wire, reinterpret_cast<const sockaddr*>(&address), sizeof address), what);
  packet_mreq all{};
  all.mr_ifindex = static_cast<int>(index);
  all.mr_type = PACKET_MR_PROMISC;
  checked(setsockopt(wire, SOL_PACKET, PACKET_ADD_MEMBERSHIP, &all, sizeof all), what);
  return wire;
}

void enter_namespace(const std::string& path) {
  const int space = checked(open(path.c_str(), O_RDONLY | O_CLOEXEC), path);
  checked(setns(space, CLONE_NEWNET), path);
  close(space);
}

/// The ends of all links: of host k the TAP device at 2k, the wire at 2k + 1.
std::vector<int> open_ends(const std::vector<std::string>& hosts) {
  const std::string folder = "/run/netns/";
  std::vector<int> ends;
  for (const std::string& host : hosts) {
    enter_namespace(folder + host);
    ends.push_back(open_tap(host));
    enter_namespace(folder + kAir);
    ends.push_back(open_wire(host));
  }
  return ends;
}

EmulatedLinks::Time now() {
  return std::chrono::steady_clock::now().time_since_epoch();
}

/// What is left until `time`.
timespec left_until(EmulatedLinks::Time time) {
  const auto left = std::max(EmulatedLinks::Time{0}, time - now());
  const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
  return {.tv_sec = seconds.count(), .tv_nsec = (left - seconds).count()};
}

[[noreturn]] void forward(const std::vector<int>& ends, const LinkOptions& options) {
  EmulatedLinks links(options, ends.size());
  const int events = checked(epoll_create1(EPOLL_CLOEXEC), "epoll");
  for (std::size_t end = 0; end < ends.size(); ++end) {
    epoll_event wanted{.events = EPOLLIN, .data = {.u64 = end}};
    checked(epoll_ctl(events, EPOLL_CTL_ADD, ends[end], &wanted), "epoll");
  }
  std::vector<std::uint8_t> buffer(kMostBytes);
  // What comes in at one end goes out at the other one of the same host. What an end does not take
  // at once is lost, as a frame is that finds no room in the hardware.
  const auto deliver = [&](std::size_t from, const EmulatedLinks::Frame& frame) {
    if (write(ends[from ^ 1U], frame.data(), frame.size()) < 0 && errno == EBADF) {
      throw std::system_error(errno, std::generic_category(), "write");
    }
  };
  std::array<epoll_event, kEvents> ready{};
  while (true) {
    const auto next = links.next();
    const timespec wait = next ? left_until(*next) : timespec{};
    const int count = epoll_pwait2(events, ready.data(), kEvents, next ? &wait : nullptr, nullptr);
    checked(count < 0 && errno == EINTR ? 0 : count, "epoll");
    for (int each = 0; each < count; ++each) {
      const std::size_t end = ready.at(static_cast<std::size_t>(each)).data.u64;
      const ssize_t size = read(ends[end], buffer.data(), buffer.size());
      if (size > static_cast<ssize_t>(kHeader)) {
        links.send(end, {buffer.begin(), buffer.begin() + size}, kHeader, now());
      }
    }
    links.advance(now(), deliver);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Loss, delay and rate on the links of the hosts of a fleet");
  double loss = 0.0;
  double delay = 0.0;
  double rate = 0.0;
  LinkOptions options;
  std::vector<std::string> hosts;
  app.add_option("--loss", loss, "% of the frames, in each direction")
      ->check(CLI::Range(0.0, kPercent));
  app.add_option("--delay", delay, "ms in each direction")->check(CLI::Range(0.0, kMostDelay));
  app.add_option("--rate", rate, "Mbit/s; 0: not limited")->check(CLI::Range(0.0, kMostRate));
  app.add_flag("--shared", options.shared, "All links and directions share the rate");
  app.add_option("HOST", hosts, "Network namespaces")->required();
  CLI11_PARSE(app, argc, argv);
  options.loss = loss / kPercent;
  options.delay = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double, std::milli>(delay));
  options.rate = rate * kBitsPerMegabit;
  try {
    const std::vector<int> ends = open_ends(hosts);
    std::cout << "ready" << std::endl;
    forward(ends, options);
  } catch (const std::exception& error) {
    std::cerr << "pipescout_link_emulator: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
}
