// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "dds_test_support.hpp"
#include "pipescout/dds/announcements.hpp"
#include "pipescout/dds/discovery_server.hpp"

namespace pipescout::dds_test {
namespace {

/// A process that says something, and listens.
struct Process {
  explicit Process(DdsOptions options, const std::string& text = "") {
    announcements->say(text);
    announcements->on_heard([this] { monitor.change([] {}); });
    options.announcements = announcements;
    transport = create_dds_transport(options);
    // A discovery server tells of those with whom there is a topic in common, as all nodes have.
    writer = transport->create_writer(text_topic("common"), QoS::latched(1), writer_record);
    reader = transport->create_reader(text_topic("common"), QoS::latched(1), reader_record);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() { announcements->on_heard({}); }

  /// Until the other one says this; an empty text: nothing.
  [[nodiscard]] bool hears(const Gid& other, const std::string& text) {
    return monitor.await([&] {
      const auto others = announcements->others();
      const auto said = others.find(other);
      return (said == others.end() ? std::string() : said->second) == text;
    });
  }
  [[nodiscard]] Gid gid() const { return transport->participant(); }

  Monitor monitor;
  std::shared_ptr<Announcements> announcements = std::make_shared<Announcements>();
  std::unique_ptr<Transport> transport;
  WriterRecord writer_record;
  ReaderRecord reader_record;
  std::unique_ptr<TransportWriter> writer;
  std::unique_ptr<TransportReader> reader;
};

void expect_to_hear_each_other(const DdsOptions& options) {
  Process one(options, "one");
  auto other = std::make_unique<Process>(options, "two=2,+/:-");
  const Gid gid = other->gid();
  EXPECT_TRUE(one.hears(gid, "two=2,+/:-"));
  EXPECT_TRUE(other->hears(one.gid(), "one"));
  // What is said later, more than once, and nothing at last.
  for (const char* text : {"more", "still more", ""}) {
    one.announcements->say(text);
    EXPECT_TRUE(other->hears(one.gid(), text)) << text;
  }
  one.announcements->say("again");
  EXPECT_TRUE(other->hears(one.gid(), "again"));
  other.reset();
  EXPECT_TRUE(one.hears(gid, "")) << "one that has gone is still heard";
}

TEST(DdsAnnouncements, AreHeardByOthersWithEachChange) {
  expect_to_hear_each_other(local_options());
}

TEST(DdsAnnouncements, AreHeardBehindADiscoveryServer) {
  const auto port = static_cast<std::uint16_t>(30000 + getpid() % 10000);
  auto options = local_options();
  options.discovery_servers.push_back({.id = 0, .host = "127.0.0.1", .port = port});
  const auto server = start_discovery_server(
      {.domain_id = options.domain_id, .id = 0, .address = "127.0.0.1", .port = port});
  expect_to_hear_each_other(options);
}

TEST(DdsAnnouncements, LeaveTheEnclaveReadable) {
  auto options = local_options();
  options.enclave = "/robots/one";
  const Process one(options, "text");
  Process other(local_options());
  EXPECT_TRUE(other.hears(one.gid(), "text"));
  ASSERT_EQ(other.transport->remote_participants().size(), 1U);
  EXPECT_EQ(other.transport->remote_participants().front().enclave, "/robots/one");
}

TEST(DdsAnnouncements, RefuseWhatOthersCouldNotRead) {
  Announcements announcements;
  EXPECT_THROW(announcements.say("a;b"), std::invalid_argument);
  EXPECT_THROW(announcements.say(std::string("a\0b", 3)), std::invalid_argument);
  EXPECT_EQ(announcements.text(), "");
}

}  // namespace
}  // namespace pipescout::dds_test
