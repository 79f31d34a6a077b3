// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dds_test_support.hpp"

namespace pipescout::dds_test {
namespace {

// RTPS 2.2, 9.6.1.1: where all participants hear of others by multicast, and where the participant
// of that number on this machine does by unicast.
constexpr const char* kDiscoveryGroup = "239.255.0.1";
std::uint16_t multicast_port(std::uint32_t domain) {
  return static_cast<std::uint16_t>(7400 + 250 * domain);
}
std::uint16_t unicast_port(std::uint32_t domain, std::uint32_t participant) {
  return static_cast<std::uint16_t>(7400 + 250 * domain + 10 + 2 * participant);
}

// What the kernel grants of what is asked for.
int receive_buffer(int descriptor) {
  int bytes = 0;
  socklen_t size = sizeof bytes;
  EXPECT_EQ(getsockopt(descriptor, SOL_SOCKET, SO_RCVBUF, &bytes, &size), 0);
  return bytes;
}

/// The sockets of this process that are bound to UDP ports of a domain.
std::vector<int> sockets_of_domain(std::uint32_t domain) {
  std::vector<int> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::stoi(entry.path().filename());
    sockaddr_in place{};
    socklen_t size = sizeof place;
    if (getsockname(descriptor, reinterpret_cast<sockaddr*>(&place), &size) == 0 &&
        place.sin_family == AF_INET && ntohs(place.sin_port) >= multicast_port(domain) &&
        ntohs(place.sin_port) < multicast_port(domain + 1)) {
      found.push_back(descriptor);
    }
  }
  return found;
}

constexpr int kGenerousMilliseconds = 30'000;

/// What comes to one address and port of the loopback interface.
class Listener {
 public:
  Listener(const char* address, std::uint16_t port)
      : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(port);
    EXPECT_EQ(inet_pton(AF_INET, address, &place.sin_addr), 1);
    const int on = 1;
    EXPECT_EQ(setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on), 0);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&place), sizeof place), 0);
    if (IN_MULTICAST(ntohl(place.sin_addr.s_addr))) {
      ip_mreq group{.imr_multiaddr = place.sin_addr, .imr_interface = {htonl(INADDR_LOOPBACK)}};
      EXPECT_EQ(setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group), 0);
    }
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() { close(socket_); }

  [[nodiscard]] bool hears_within(int milliseconds) const {
    pollfd ready{socket_, POLLIN, 0};
    return poll(&ready, 1, milliseconds) == 1;
  }
  /// The first bytes of a datagram.
  [[nodiscard]] std::string take() const {
    std::array<char, 4> magic{};
    const ssize_t size = recv(socket_, magic.data(), magic.size(), 0);
    return {magic.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
  }

 private:
  int socket_;
};

// A participant of another vendor on a loopback interface without multicast is found soon only if
// it is spoken to: otherwise it tells of itself every 8 s or so.
TEST(DdsDiscovery, AnnouncesByUnicastToTheParticipantsOfThisMachine) {
  const auto options = local_options();
  const Listener other("127.0.0.1", unicast_port(options.domain_id, 25));
  const auto transport = create_dds_transport(options);
  ASSERT_TRUE(other.hears_within(kGenerousMilliseconds)) << "nothing came";
  EXPECT_EQ(other.take(), "RTPS");
}

// Where every vendor's participants listen, and with one datagram: each costs every host of the
// network a packet.
TEST(DdsDiscovery, AnnouncesByMulticastToTheStandardPortAlone) {
  const auto options = local_options();
  const Listener standard(kDiscoveryGroup, multicast_port(options.domain_id));
  const Listener another(kDiscoveryGroup, unicast_port(options.domain_id, 25));
  const auto transport = create_dds_transport(options);
  // Once the second announcement is there, all of the first has been sent.
  for (int announcement = 0; announcement < 2; ++announcement) {
    ASSERT_TRUE(standard.hears_within(kGenerousMilliseconds)) << "nothing came";
    EXPECT_EQ(standard.take(), "RTPS");
  }
  EXPECT_FALSE(another.hears_within(0));
}

// Twenty other processes tell of all their endpoints at once, which are some MB.
TEST(DdsDiscovery, SocketsHaveRoomForWhatAFleetTellsAtOnce) {
  constexpr int kWanted = 4 * 1024 * 1024;
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(setsockopt(probe, SOL_SOCKET, SO_RCVBUF, &kWanted, sizeof kWanted), 0);
  const int granted = receive_buffer(probe);
  close(probe);
  const auto options = local_options();
  const auto transport = create_dds_transport(options);
  const auto sockets = sockets_of_domain(options.domain_id);
  EXPECT_FALSE(sockets.empty());
  for (const int each : sockets) {
    EXPECT_EQ(receive_buffer(each), granted);
  }
}

/// Another process that holds the two ports of a participant and says nothing.
class SilentProcess {
 public:
  explicit SilentProcess(std::uint32_t domain) {
    std::array<int, 2> ready{};
    EXPECT_EQ(pipe(ready.data()), 0);
    pid_ = fork();
    if (pid_ == 0) {
      for (std::uint32_t participant = 60;; ++participant) {
        if (hold(unicast_port(domain, participant))) {
          const std::uint16_t port = unicast_port(domain, participant);
          (void)!write(ready[1], &port, sizeof port);
          pause();
        }
      }
    }
    EXPECT_EQ(read(ready[0], &port_, sizeof port_), static_cast<ssize_t>(sizeof port_));
    close(ready[0]);
    close(ready[1]);
  }
  SilentProcess(const SilentProcess&) = delete;
  SilentProcess& operator=(const SilentProcess&) = delete;
  ~SilentProcess() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] std::uint16_t port() const { return port_; }

 private:
  static bool hold(std::uint16_t first) {
    for (const int each : {0, 1}) {
      sockaddr_in place{};
      place.sin_family = AF_INET;
      place.sin_port = htons(static_cast<std::uint16_t>(first + each));
      const int held = socket(AF_INET, SOCK_DGRAM, 0);
      if (bind(held, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0) {
        return false;
      }
    }
    return true;
  }

  pid_t pid_ = -1;
  std::uint16_t port_ = 0;
};

// Who is found first must not end the search for the others.
TEST(DdsCensus, CountsWhoHoldsSocketsOfTheDomainAndHasNotAnswered) {
  const auto options = local_options();
  const SilentProcess silent(options.domain_id);
  const auto transport = create_dds_transport(options);
  const auto unheard = transport->take_census();
  const auto found = std::find_if(unheard.begin(), unheard.end(),
                                  [&](const auto& each) { return each.port == silent.port(); });
  ASSERT_NE(found, unheard.end());
  EXPECT_EQ(found->process, silent.pid());
  EXPECT_FALSE(found->has_no_udp);
}

TEST(DdsCensus, CountsNobodyWhoIsDiscoveredAndForgetsWhoWasKilled) {
  const auto options = local_options();
  const pid_t other = fork();
  if (other == 0) {
    const auto transport = create_dds_transport(options);
    while (true) {
      pause();
    }
  }
  const auto transport = create_dds_transport(options);
  Monitor monitor;
  transport->on_graph_changed([&] { monitor.change([] {}); });
  ASSERT_TRUE(monitor.await([&] { return !transport->remote_participants().empty(); }));
  EXPECT_TRUE(transport->remote_participants().front().is_on_loopback_alone);
  const auto unheard = transport->take_census();
  EXPECT_TRUE(std::none_of(unheard.begin(), unheard.end(),
                           [&](const auto& each) { return each.process == other; }));
  EXPECT_EQ(transport->remote_participants().size(), 1U);
  kill(other, SIGKILL);
  waitpid(other, nullptr, 0);
  (void)transport->take_census();
  EXPECT_TRUE(transport->remote_participants().empty());
  transport->on_graph_changed({});
}

}  // namespace
}  // namespace pipescout::dds_test
