// SPDX-License-Identifier: Apache-2.0
#include "shortcut_transport.hpp"

#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/transport/TransportInterface.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>
#include <fastrtps/utils/IPLocator.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>
#include <fastdds/rtps/common/LocatorList.hpp>

#include <array>
#include <csignal>
#include <cstdio>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "dds_test_support.hpp"
#include "participant.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout {
namespace {

namespace rtps = eprosima::fastdds::rtps;
using dds::note_memory;
using dds::ReaderProbe;
using dds::shared_memory_port;
using dds::ShortcutTransportDescriptor;
using dds_test::Monitor;
using eprosima::fastrtps::rtps::IPLocator;
using ::testing::ElementsAre;

// Above the ports of DDS domains; each test program has some of its own.
std::uint16_t test_port(int index) {
  return static_cast<std::uint16_t>(61000 + getpid() % 400 * 10 + index);
}

rtps::Locator udp_locator(std::uint16_t port, const std::string& address = "127.0.0.1") {
  rtps::Locator locator;
  IPLocator::createLocator(LOCATOR_KIND_UDPv4, address, port, locator);
  return locator;
}

std::unique_ptr<rtps::TransportInterface> initialised(
    const rtps::TransportDescriptorInterface& descriptor) {
  std::unique_ptr<rtps::TransportInterface> transport(descriptor.create_transport());
  if (!transport->init()) {
    throw std::runtime_error("no transport");
  }
  return transport;
}

ShortcutTransportDescriptor shortcut() {
  ShortcutTransportDescriptor descriptor;
  descriptor.interfaceWhiteList.emplace_back("127.0.0.1");
  descriptor.shared_memory.segment_size(std::uint32_t{1} << 20);
  return descriptor;
}

/// Listens on a port and keeps what comes, with the kind of the channel on which it came.
class Receiver final : public rtps::TransportReceiverInterface {
 public:
  struct Datagram {
    std::string text;
    std::int32_t kind;
    bool operator==(const Datagram&) const = default;
  };

  Receiver(const rtps::TransportDescriptorInterface& descriptor, const rtps::Locator& locator)
      : transport_(initialised(descriptor)), locator_(locator) {
    if (!transport_->OpenInputChannel(locator_, this, 65500)) {
      throw std::runtime_error("port is taken");
    }
  }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  ~Receiver() override { transport_->CloseInputChannel(locator_); }

  void OnDataReceived(const std::uint8_t* data, std::uint32_t size, const rtps::Locator& local,
                      const rtps::Locator&) override {
    monitor_.change([&] { datagrams_.push_back({{data, data + size}, local.kind}); });
  }
  /// All up to the one with this text.
  std::vector<Datagram> until(const std::string& text) {
    EXPECT_TRUE(
        monitor_.await([&] { return !datagrams_.empty() && datagrams_.back().text == text; }));
    return monitor_.copy(datagrams_);
  }

 private:
  Monitor monitor_;
  std::vector<Datagram> datagrams_;
  std::unique_ptr<rtps::TransportInterface> transport_;
  rtps::Locator locator_;
};

/// Another process that receives on a port; killed with this object.
class ReceiverProcess {
 public:
  explicit ReceiverProcess(std::uint16_t port) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error("no pipe");
    }
    output_.reset(fdopen(ends[0], "r"));
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    std::string program = RECEIVER_PROGRAM;
    std::string argument = std::to_string(port);
    std::array<char*, 3> arguments{program.data(), argument.data(), nullptr};
    const int failure =
        posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (failure != 0 || line() != "listening") {
      throw std::runtime_error("the program does not listen");
    }
  }
  ReceiverProcess(const ReceiverProcess&) = delete;
  ReceiverProcess& operator=(const ReceiverProcess&) = delete;
  ~ReceiverProcess() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  /// The next one that it prints, without its end; empty when it ended.
  std::string line() {
    std::array<char, 80> text{};
    if (fgets(text.data(), static_cast<int>(text.size()), output_.get()) == nullptr) {
      return {};
    }
    std::string result = text.data();
    result.pop_back();
    return result;
  }

 private:
  struct Close {
    void operator()(FILE* file) const { fclose(file); }
  };
  std::unique_ptr<FILE, Close> output_;
  pid_t process_ = 0;
};

/// The messages that wait in shared memory go with it.
class Sender {
 public:
  explicit Sender(const rtps::TransportDescriptorInterface& descriptor)
      : transport_(initialised(descriptor)) {}

  void send(const std::string& text, const std::vector<rtps::Locator>& destinations) {
    rtps::LocatorList locators;
    for (const auto& destination : destinations) {
      transport_->OpenOutputChannel(senders_, destination);
      locators.push_back(destination);
    }
    for (const auto& sender : senders_) {
      rtps::Locators begin(locators.begin());
      rtps::Locators end(locators.end());
      sender->send(reinterpret_cast<const std::uint8_t*>(text.data()),
                   static_cast<std::uint32_t>(text.size()), &begin, &end,
                   std::chrono::steady_clock::now() + std::chrono::seconds(1));
    }
  }

 private:
  std::unique_ptr<rtps::TransportInterface> transport_;
  rtps::SendResourceList senders_;
};

TEST(ShortcutTransportTest, TakesTheShortcutToItsOwnKind) {
  Receiver receiver(shortcut(), udp_locator(test_port(0)));
  Sender sender(shortcut());
  sender.send("hello", {udp_locator(test_port(0))});
  EXPECT_THAT(receiver.until("hello"), ElementsAre(Receiver::Datagram{"hello", LOCATOR_KIND_SHM}));
}

TEST(ShortcutTransportTest, SpeaksUdpToOthers) {
  rtps::UDPv4TransportDescriptor plain;
  plain.interfaceWhiteList.emplace_back("127.0.0.1");
  Receiver theirs(plain, udp_locator(test_port(1)));
  Sender sender(shortcut());
  sender.send("to them", {udp_locator(test_port(1))});
  EXPECT_THAT(theirs.until("to them"),
              ElementsAre(Receiver::Datagram{"to them", LOCATOR_KIND_UDPv4}));
  Receiver ours(shortcut(), udp_locator(test_port(2)));
  Sender stranger(plain);
  stranger.send("to us", {udp_locator(test_port(2))});
  EXPECT_THAT(ours.until("to us"), ElementsAre(Receiver::Datagram{"to us", LOCATOR_KIND_UDPv4}));
}

TEST(ShortcutTransportTest, ServesBothKindsWithOneSend) {
  rtps::UDPv4TransportDescriptor plain;
  plain.interfaceWhiteList.emplace_back("127.0.0.1");
  Receiver theirs(plain, udp_locator(test_port(3)));
  Receiver ours(shortcut(), udp_locator(test_port(4)));
  Sender sender(shortcut());
  sender.send("both", {udp_locator(test_port(3)), udp_locator(test_port(4))});
  EXPECT_THAT(theirs.until("both"), ElementsAre(Receiver::Datagram{"both", LOCATOR_KIND_UDPv4}));
  EXPECT_THAT(ours.until("both"), ElementsAre(Receiver::Datagram{"both", LOCATOR_KIND_SHM}));
}

TEST(ShortcutTransportTest, FollowsAPortFromOneProcessToTheNext) {
  rtps::UDPv4TransportDescriptor plain;
  plain.interfaceWhiteList.emplace_back("127.0.0.1");
  Sender sender(shortcut());
  {
    Receiver first(shortcut(), udp_locator(test_port(5)));
    sender.send("first", {udp_locator(test_port(5))});
    EXPECT_EQ(first.until("first").back().kind, LOCATOR_KIND_SHM);
  }
  {
    Receiver second(plain, udp_locator(test_port(5)));
    sender.send("second", {udp_locator(test_port(5))});
    EXPECT_EQ(second.until("second").back().kind, LOCATOR_KIND_UDPv4);
  }
  Receiver third(shortcut(), udp_locator(test_port(5)));
  sender.send("third", {udp_locator(test_port(5))});
  EXPECT_EQ(third.until("third").back().kind, LOCATOR_KIND_SHM);
}

TEST(ShortcutTransportTest, ReachesTheProcessThatHasThePortOfAKilledOne) {
  Sender sender(shortcut());
  {
    ReceiverProcess killed(test_port(6));
    sender.send("first", {udp_locator(test_port(6))});
    EXPECT_EQ(killed.line(), "first");
  }
  Receiver next(shortcut(), udp_locator(test_port(6)));
  sender.send("second", {udp_locator(test_port(6))});
  EXPECT_EQ(next.until("second").size(), 1U);
  sender.send("third", {udp_locator(test_port(6))});
  EXPECT_EQ(next.until("third").size(), 2U);
}

TEST(ShortcutTransportTest, ReachesAReaderWhoseMemoryASenderMadeAnew) {
  Receiver receiver(shortcut(), udp_locator(test_port(7)));
  // As a sender does that found the reader standing still.
  const auto memory = std::filesystem::path(dds::kSharedMemoryFolder) /
                      ("fastrtps_port" + std::to_string(shared_memory_port(test_port(7))));
  const std::filesystem::path anew = memory.string() + "_anew";
  std::filesystem::copy_file(memory, anew);
  std::filesystem::rename(anew, memory);
  Sender sender(shortcut());
  sender.send("hello", {udp_locator(test_port(7))});
  EXPECT_THAT(receiver.until("hello"),
              ElementsAre(Receiver::Datagram{"hello", LOCATOR_KIND_UDPv4}));
}

TEST(ShortcutTransportTest, SendsOnceToAProcessWithSeveralAddresses) {
  ShortcutTransportDescriptor everywhere = shortcut();
  everywhere.interfaceWhiteList.clear();
  Receiver receiver(everywhere, udp_locator(test_port(6)));
  std::vector<rtps::Locator> addresses = {udp_locator(test_port(6))};
  const auto transport = initialised(everywhere);
  for (const auto& address : transport->NormalizeLocator(udp_locator(test_port(6), "0.0.0.0"))) {
    addresses.push_back(address);
  }
  Sender sender(everywhere);
  sender.send("one", addresses);
  sender.send("two", {addresses.front()});
  EXPECT_EQ(receiver.until("two").size(), 2U);
}

// Behind so many bytes a writer asks all its readers what they lack, also those to which it is
// still on its way: twenty processes are told of 200 endpoints with 500 bytes each.
TEST(ShortcutTransportTest, AWriterTellsAFleetOfItsEndpointsWithoutAHeartbeatInBetween) {
  const std::unique_ptr<rtps::TransportInterface> transport(
      ShortcutTransportDescriptor().create_transport());
  EXPECT_GT(transport->get_configuration()->min_send_buffer_size(), 20U * 200U * 500U);
}

TEST(ReaderProbeTest, AsksForTheLockOfThePort) {
  const testing::TemporaryFolder folder;
  ReaderProbe probe(folder.path());
  EXPECT_FALSE(probe.has_reader(70000));
  const auto file = folder.path() / "fastrtps_port70000_el";
  const int reader = open(file.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC, 0600);
  ASSERT_GE(reader, 0);
  EXPECT_FALSE(probe.has_reader(70000)) << "left behind by a killed process";
  ASSERT_EQ(flock(reader, LOCK_EX | LOCK_NB), 0) << "the probe must not keep the lock";
  EXPECT_FALSE(probe.has_reader(70000)) << "no memory";
  EXPECT_FALSE(note_memory(70000, folder.path()));
  std::ofstream(folder.path() / "fastrtps_port70000") << "memory";
  EXPECT_FALSE(probe.has_reader(70000)) << "of whom nobody knows";
  EXPECT_TRUE(note_memory(70000, folder.path()));
  EXPECT_TRUE(probe.has_reader(70000));
  EXPECT_TRUE(probe.has_reader(70000));
  EXPECT_FALSE(probe.has_reader(70001));
  close(reader);
  EXPECT_FALSE(probe.has_reader(70000));
}

TEST(ReaderProbeTest, DoesNotTrustMemoryThatWasMadeAnew) {
  const testing::TemporaryFolder folder;
  const auto lock = folder.path() / "fastrtps_port70000_el";
  const auto memory = folder.path() / "fastrtps_port70000";
  // Fast DDS removes the lock of a reader that is gone.
  const auto start_reader = [&] {
    std::filesystem::remove(lock);
    const int reader = open(lock.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC, 0600);
    EXPECT_EQ(flock(reader, LOCK_EX | LOCK_NB), 0);
    EXPECT_TRUE(note_memory(70000, folder.path()));
    return reader;
  };
  std::ofstream(memory) << "first";
  // As a sender that has it open: its inode is not used again.
  const std::ifstream sender(memory);
  ReaderProbe probe(folder.path());
  const int first = start_reader();
  EXPECT_TRUE(probe.has_reader(70000));
  close(first);
  const int ended_by_itself = start_reader();
  EXPECT_TRUE(probe.has_reader(70000));
  close(ended_by_itself);
  std::filesystem::remove(memory);
  std::ofstream(memory) << "second";
  const int after_a_kill = start_reader();
  EXPECT_FALSE(probe.has_reader(70000));
  close(after_a_kill);
}

TEST(ReaderProbeTest, DoesNotTrustMemoryThatTheReaderDoesNotKnow) {
  const testing::TemporaryFolder folder;
  const auto memory = folder.path() / "fastrtps_port70000";
  std::ofstream(memory) << "of the reader";
  const int reader = open((memory.string() + "_el").c_str(), O_RDONLY | O_CREAT | O_CLOEXEC, 0600);
  ASSERT_EQ(flock(reader, LOCK_EX | LOCK_NB), 0);
  ASSERT_TRUE(note_memory(70000, folder.path()));
  ReaderProbe known(folder.path());
  EXPECT_TRUE(known.has_reader(70000));
  const std::ifstream of_the_reader(memory);  // its inode is not used again
  std::filesystem::remove(memory);
  EXPECT_FALSE(known.has_reader(70000));
  std::ofstream(memory) << "of a sender";
  EXPECT_FALSE(known.has_reader(70000));
  EXPECT_FALSE(ReaderProbe(folder.path()).has_reader(70000));
  close(reader);
}

TEST(SharedMemoryPortTest, IsNoneThatFastDdsUses) {
  EXPECT_GT(shared_memory_port(0), 0xFFFFU);
  EXPECT_EQ(shared_memory_port(7411) & 0xFFFF, 7411U);
  EXPECT_EQ(shared_memory_port(7411), shared_memory_port(7411));
}

/// Keeps the locators that a remote participant announces.
class LocatorListener final : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  void on_participant_discovery(
      eprosima::fastdds::dds::DomainParticipant*,
      eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& found) override {
    monitor.change([&] {
      for (const auto* locators :
           {&found.info.default_locators, &found.info.metatraffic_locators}) {
        for (const auto& locator : locators->unicast) {
          kinds.push_back(locator.kind);
        }
      }
    });
  }
  Monitor monitor;
  std::vector<std::int32_t> kinds;
};

TEST(ShortcutTransportTest, NobodyIsToldOfTheSharedMemory) {
  DdsOptions options;
  options.domain_id = static_cast<std::uint32_t>(1 + getpid() % 200);
  options.localhost_only = true;
  LocatorListener listener;
  auto* factory = eprosima::fastdds::dds::DomainParticipantFactory::get_instance();
  eprosima::fastdds::dds::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  auto udp = std::make_shared<rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  auto* stranger = factory->create_participant(options.domain_id, qos, &listener,
                                               eprosima::fastdds::dds::StatusMask::none());
  ASSERT_NE(stranger, nullptr);
  {
    const dds::Participant ours(options);
    EXPECT_TRUE(listener.monitor.await([&] { return !listener.kinds.empty(); }));
  }
  EXPECT_THAT(listener.monitor.copy(listener.kinds), ::testing::Each(LOCATOR_KIND_UDPv4));
  factory->delete_participant(stranger);
}

}  // namespace
}  // namespace pipescout
