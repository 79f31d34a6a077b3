// SPDX-License-Identifier: Apache-2.0
#include "signs_of_life.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::dds {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

// RTPS 2.2, 9.6.1.1, for domain 3.
constexpr std::uint32_t kDomain = 3;
constexpr std::uint16_t kMulticast = 8150;
constexpr std::uint16_t kFirst = 8160;

Gid participant(std::uint8_t number) {
  Gid gid;
  gid.bytes[0] = number;
  return gid;
}

SocketOwners owned(int process, const std::string& program,
                   const std::vector<BoundSocket>& sockets) {
  SocketOwners owners;
  for (const BoundSocket& socket : sockets) {
    owners[socket.inode] = {process, program};
  }
  return owners;
}

TEST(BoundSockets, AreReadAsTheKernelListsThem) {
  const ::pipescout::testing::TemporaryFolder proc;
  fs::create_directories(proc.path() / "self/net");
  std::ofstream(proc.path() / "self/net/udp")
      << "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  "
         "timeout inode ref pointer drops\n"
         "  410: 00000000:1FD6 00000000:0000 07 00000000:00000000 00:00000000 00000000     0"
         "        0 41170 2 0000000000000000 0\n"
         "  420: 0100007F:1FE0 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000"
         "        0 41171 2 0000000000000000 0\n"
         "  430: what this is nobody knows\n";
  EXPECT_THAT(bound_sockets(proc.path()),
              ElementsAre(BoundSocket{8150, 41170}, BoundSocket{8160, 41171}));
  EXPECT_THAT(bound_sockets(proc.path() / "nowhere"), IsEmpty());
}

TEST(BoundSockets, BelongToTheProcessesThatHaveThemOpen) {
  const ::pipescout::testing::TemporaryFolder proc;
  fs::create_directories(proc.path() / "4711/fd");
  fs::create_directories(proc.path() / "sys/fd");
  std::ofstream(proc.path() / "4711/comm") << "talker\n";
  fs::create_symlink("socket:[41170]", proc.path() / "4711/fd/3");
  fs::create_symlink("/dev/null", proc.path() / "4711/fd/4");
  fs::create_symlink("socket:[9]", proc.path() / "4711/fd/5");
  const auto owners = owners_of({{8150, 41170}, {8160, 41171}}, proc.path());
  ASSERT_EQ(owners.size(), 1U);
  EXPECT_EQ(owners.at(41170).process, 4711);
  EXPECT_EQ(owners.at(41170).program, "talker");
}

TEST(Census, TellsWhoHoldsThePortsOfAParticipantAndWasNotHeard) {
  const std::vector<BoundSocket> sockets{
      {kMulticast, 1}, {kFirst, 2}, {kFirst + 1, 3}, {kFirst + 2, 4}, {kFirst + 3, 5}};
  auto owners = owned(10, "talker", {sockets[0], sockets[1], sockets[2]});
  owners.merge(owned(11, "listener", {sockets[3], sockets[4]}));
  Census census(kDomain);
  EXPECT_THAT(census.count(sockets, owners, {}).unheard,
              ElementsAre(UnheardParticipant{10, "talker", kFirst},
                          UnheardParticipant{11, "listener", kFirst + 2}));
  const auto one_heard = census.count(sockets, owners, {{participant(1), {kFirst}}});
  EXPECT_THAT(one_heard.unheard, ElementsAre(UnheardParticipant{11, "listener", kFirst + 2}));
  EXPECT_THAT(one_heard.departed, IsEmpty());
}

TEST(Census, TakesAPortThatAnotherProcessHoldsForThatOfTheOther) {
  // Fast DDS announces the port that it tried first beside the one that it got.
  const std::vector<BoundSocket> sockets{
      {kFirst, 2}, {kFirst + 1, 3}, {kFirst + 2, 4}, {kFirst + 3, 5}};
  auto owners = owned(70'010, "talker", {sockets[0], sockets[1]});
  owners.merge(owned(70'011, "listener", {sockets[2], sockets[3]}));
  Gid listener;
  listener.bytes = {1, 15, 0, 0, 70'011 & 0xFF, 70'011 >> 8 & 0xFF};
  EXPECT_THAT(Census(kDomain).count(sockets, owners, {{listener, {kFirst, kFirst + 2}}}).unheard,
              ElementsAre(UnheardParticipant{70'010, "talker", kFirst}));
}

TEST(Census, HasThePortsOfOtherUsersAlone) {
  const std::vector<BoundSocket> sockets{{kFirst + 4, 2}, {kFirst + 5, 3}};
  EXPECT_THAT(Census(kDomain).count(sockets, {}, {}).unheard,
              ElementsAre(UnheardParticipant{0, "", kFirst + 4}));
}

TEST(Census, DoesNotTakeEachPortOfTheDomainForThatOfAParticipant) {
  // A program that sends gets any port from 32768 on, where domains from 102 on have theirs.
  const std::vector<BoundSocket> sockets{{kFirst + 4, 2}, {kFirst + 7, 3}};
  EXPECT_THAT(Census(kDomain).count(sockets, owned(10, "browser", sockets), {}).unheard, IsEmpty());
}

TEST(Census, KnowsWhoTakesPortsOfItsOwnByTheMulticastPort) {
  const std::vector<BoundSocket> sockets{{kMulticast, 1}, {40'000, 2}};
  const auto owners = owned(10, "cyclone", sockets);
  Census census(kDomain);
  EXPECT_THAT(census.count(sockets, owners, {}).unheard,
              ElementsAre(UnheardParticipant{10, "cyclone", 0}));
  EXPECT_THAT(census.count(sockets, owners, {{participant(1), {40'000}}}).unheard, IsEmpty());
}

TEST(Census, LeavesOutWhoseSocketsAreClosed) {
  const std::vector<BoundSocket> before{{kFirst, 2}, {kFirst + 1, 3}};
  Census census(kDomain);
  const PortsByParticipant discovered{{participant(1), {kFirst}}, {participant(2), {}}};
  EXPECT_THAT(census.count(before, owned(10, "talker", before), discovered).departed, IsEmpty());
  // Another one has the port now: it is not the one that was discovered.
  const std::vector<BoundSocket> after{{kFirst, 12}, {kFirst + 1, 13}};
  const auto result = census.count(after, owned(20, "other", after), discovered);
  EXPECT_THAT(result.departed, ElementsAre(participant(1)));
  EXPECT_THAT(result.unheard, ElementsAre(UnheardParticipant{20, "other", kFirst}));
}

TEST(Census, HasNoPortsAboveTheLastOne) {
  // Domain 232 begins at 65400 and would end at 65649.
  std::vector<BoundSocket> sockets;
  for (std::uint32_t port = 65400; port <= 65535; ++port) {
    sockets.push_back({static_cast<std::uint16_t>(port), port});
  }
  EXPECT_EQ(Census(232).count(sockets, {}, {}).unheard.size(), (65535U - 65410U + 1U) / 2U);
}

TEST(PortsOfSharedMemoryAlone, AreThoseWithAReaderAndNoSocket) {
  const ::pipescout::testing::TemporaryFolder folder;
  const auto lock = [&](std::uint16_t port) {
    const auto path = folder.path() / ("fastrtps_port" + std::to_string(port) + "_el");
    const int file = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
    EXPECT_EQ(flock(file, LOCK_EX | LOCK_NB), 0);
    return file;
  };
  const int with_udp = lock(kFirst);
  const int without = lock(kFirst + 2);
  std::ofstream(folder.path() / ("fastrtps_port" + std::to_string(kFirst + 4) + "_el")) << "";
  EXPECT_THAT(ports_of_shared_memory_alone({{kFirst, 2}}, kDomain, folder.path()),
              UnorderedElementsAre(kFirst + 2));
  close(with_udp);
  close(without);
}

}  // namespace
}  // namespace pipescout::dds
