// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <string_view>

#include "dds_test_support.hpp"

namespace pipescout::dds_test {
namespace {

/// Where the participant of that number on this machine hears of others by unicast
/// (RTPS 2.2, 9.6.1.1).
std::uint16_t discovery_port(std::uint32_t domain, std::uint32_t participant) {
  return static_cast<std::uint16_t>(7400 + 250 * domain + 10 + 2 * participant);
}

// A participant of another vendor on a loopback interface without multicast is found soon only if
// it is spoken to: otherwise it tells of itself every 8 s or so.
TEST(DdsDiscovery, AnnouncesByUnicastToTheParticipantsOfThisMachine) {
  const auto options = local_options();
  const int other = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ASSERT_GE(other, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(discovery_port(options.domain_id, 25));
  ASSERT_EQ(bind(other, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);

  const auto transport = create_dds_transport(options);
  pollfd ready{other, POLLIN, 0};
  constexpr int kGenerousMilliseconds = 30'000;
  ASSERT_EQ(poll(&ready, 1, kGenerousMilliseconds), 1) << "nothing came";
  std::array<char, 4> magic{};
  EXPECT_EQ(recv(other, magic.data(), magic.size(), 0), 4);
  EXPECT_EQ(std::string_view(magic.data(), magic.size()), "RTPS");
  close(other);
}

}  // namespace
}  // namespace pipescout::dds_test
