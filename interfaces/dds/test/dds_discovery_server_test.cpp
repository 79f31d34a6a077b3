// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "dds_profile.hpp"
#include "dds_test_support.hpp"
#include "pipescout/dds/discovery_server.hpp"

namespace pipescout::dds_test {
namespace {

using ::testing::HasSubstr;

/// Apart from those of other tests.
std::uint16_t server_port(int server) {
  return static_cast<std::uint16_t>(20000 + 2 * (getpid() % 5000) + server);
}

DdsOptions client_options(int servers) {
  auto options = local_options();
  for (int id = 0; id < servers; ++id) {
    options.discovery_servers.push_back(
        {.id = static_cast<std::uint8_t>(id), .host = "127.0.0.1", .port = server_port(id)});
  }
  return options;
}

std::unique_ptr<DiscoveryServer> start(int id) {
  return start_discovery_server({.domain_id = local_options().domain_id,
                                 .id = static_cast<std::uint8_t>(id),
                                 .address = "127.0.0.1",
                                 .port = server_port(id)});
}

void expect_to_talk(Transport& from, Transport& to, const std::string& name) {
  WriterRecord writer_record;
  ReaderRecord reader_record;
  const auto writer = from.create_writer(text_topic(name), QoS::latched(1), writer_record);
  const auto reader = to.create_reader(text_topic(name), QoS::latched(1), reader_record);
  const auto message = make_text("hello");
  writer->write(&message, {});
  ASSERT_TRUE(reader_record.await_messages(1));
  EXPECT_EQ(reader_record.text(0), "hello");
}

/// Until there are warnings, or none.
bool await_warnings(Transport& transport, bool any) {
  Monitor monitor;
  const auto call = transport.create_delayed_call([&] { monitor.change([] {}); });
  return monitor.await([&] {
    call->start(std::chrono::milliseconds(50));
    return transport.warnings().empty() != any;
  });
}

TEST(DdsDiscoveryServer, ItsClientsFindEachOther) {
  const auto server = start(0);
  const auto one = create_dds_transport(client_options(1));
  const auto other = create_dds_transport(client_options(1));
  expect_to_talk(*one, *other, "by_server");
}

TEST(DdsDiscoveryServer, ItsClientsFindEachOtherAtALimitedRate) {
  DiscoveryServerOptions options{.domain_id = local_options().domain_id,
                                 .id = 0,
                                 .address = "127.0.0.1",
                                 .port = server_port(0)};
  options.network = {.kind = NetworkProfile::Kind::kWifi, .rate = 0.5};
  const auto server = start_discovery_server(options);
  const auto one = create_dds_transport(client_options(1));
  const auto other = create_dds_transport(client_options(1));
  expect_to_talk(*one, *other, "by_slow_server");
}

TEST(DdsDiscoveryServer, OneOfTwoIsEnough) {
  const auto server = start(1);
  const auto one = create_dds_transport(client_options(2));
  const auto other = create_dds_transport(client_options(2));
  expect_to_talk(*one, *other, "by_second_server");
}

TEST(DdsDiscoveryServer, OneThatIsNotThereIsNamedUntilItComes) {
  const auto transport = create_dds_transport(client_options(1));
  ASSERT_TRUE(await_warnings(*transport, true)) << "nothing was said";
  EXPECT_THAT(transport->warnings().front(),
              HasSubstr("127.0.0.1:" + std::to_string(server_port(0)) + " (id 0) does not answer"));
  const auto server = start(0);
  EXPECT_TRUE(await_warnings(*transport, false)) << transport->warnings().front();
}

TEST(DdsDiscoveryServer, OneThatComesBackServesItsOldClients) {
  auto server = start(0);
  const auto one = create_dds_transport(client_options(1));
  const auto other = create_dds_transport(client_options(1));
  expect_to_talk(*one, *other, "before");
  server.reset();
  server = start(0);
  const auto late = create_dds_transport(client_options(1));
  expect_to_talk(*one, *late, "after");
}

TEST(DdsDiscoveryServer, APortInUseIsAnError) {
  const auto server = start(0);
  try {
    const auto second = start(0);
    ADD_FAILURE() << "was started";
  } catch (const TransportError& error) {
    EXPECT_THAT(error.what(), HasSubstr("127.0.0.1:" + std::to_string(server_port(0))));
  }
}

TEST(DdsDiscoveryServer, ANameThatNobodyKnowsIsSaid) {
  auto options = local_options();
  options.discovery_servers.push_back({.host = "no-such-host.invalid"});
  const auto transport = create_dds_transport(options);
  ASSERT_FALSE(transport->warnings().empty());
  EXPECT_THAT(transport->warnings().front(), HasSubstr("no-such-host.invalid:11811"));
}

TEST(DdsStaticPeers, AreSpokenTo) {
  auto options = local_options();
  options.static_peers = {"127.0.0.1", "no-such-host.invalid"};
  const auto transport = create_dds_transport(options);
  ASSERT_FALSE(transport->warnings().empty());
  EXPECT_THAT(transport->warnings().front(), HasSubstr("peer no-such-host.invalid"));
  const auto other = create_dds_transport(local_options());
  expect_to_talk(*transport, *other, "by_peer");
}

}  // namespace
}  // namespace pipescout::dds_test
