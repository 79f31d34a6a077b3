// SPDX-License-Identifier: Apache-2.0
// What a fleet sets for its network, with security on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/pem.h>

#include <ctime>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "dds_profile.hpp"
#include "pipescout/keystore/policy.hpp"
#include "secured.hpp"

namespace pipescout::security {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

class SecuredNetwork : public Secured {
 protected:
  /// As the authority of the permissions.
  void sign(const std::string& document, const fs::path& signed_document) const {
    const auto open = [](const fs::path& file, const char* mode) {
      return std::unique_ptr<BIO, decltype(&BIO_free)>(BIO_new_file(file.c_str(), mode), BIO_free);
    };
    const std::unique_ptr<X509, decltype(&X509_free)> authority(
        PEM_read_bio_X509(open(keystore_ / "public/permissions_ca.cert.pem", "r").get(), nullptr,
                          nullptr, nullptr),
        X509_free);
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
        PEM_read_bio_PrivateKey(open(keystore_ / "private/permissions_ca.key.pem", "r").get(),
                                nullptr, nullptr, nullptr),
        EVP_PKEY_free);
    const auto text = [&] {
      return std::unique_ptr<BIO, decltype(&BIO_free)>(
          BIO_new_mem_buf(document.data(), static_cast<int>(document.size())), BIO_free);
    };
    constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
    const std::unique_ptr<PKCS7, decltype(&PKCS7_free)> signature(
        PKCS7_sign(authority.get(), key.get(), nullptr, text().get(), kFlags), PKCS7_free);
    ASSERT_EQ(
        SMIME_write_PKCS7(open(signed_document, "w").get(), signature.get(), text().get(), kFlags),
        1);
  }
};

/// The handshake outgrows the datagrams of the profile, the more so with many rights.
TEST_F(SecuredNetwork, RobotsWithTheProfileForWifiTalk) {
  keystore::EnclavePolicy policy;
  for (int topic = 0; topic < 300; ++topic) {
    policy.publish.insert("/a_topic_with_a_long_name/" + std::to_string(topic));
  }
  policy.publish.insert("/secret");
  policy.subscribe.insert("/secret");
  keystore::create_enclave(keystore_, {.name = "/rich", .domain = domain(), .policy = policy},
                           std::time(nullptr));
  auto robot = options(keystore_, "/rich");
  robot.network.kind = NetworkProfile::Kind::kWifi;
  auto station = options(keystore_, "/robot_2");
  station.network.kind = NetworkProfile::Kind::kWifi;
  Peer from(robot);
  Peer to(station);
  ASSERT_TRUE(from.written.await_matched(1));
  ASSERT_TRUE(to.read.await_matched(1));
  const std::string text(300'000, 'x');
  from.say(text);
  from.say("small");
  ASSERT_TRUE(to.read.await_messages(2));
  EXPECT_EQ(to.heard(text), 1U);
  EXPECT_EQ(to.heard("small"), 1U);
}

TEST_F(SecuredNetwork, PeersFindEachOther) {
  auto first = options(keystore_, "/robot_1");
  first.static_peers = {"127.0.0.1"};
  Peer one(first);
  Peer other(options(keystore_, "/robot_2"));
  ASSERT_TRUE(one.written.await_matched(1));
  ASSERT_TRUE(other.read.await_matched(1));
  one.say("hello");
  ASSERT_TRUE(other.read.await_messages(1));
}

/// Rather than to start, and to find nobody.
TEST_F(SecuredNetwork, ADiscoveryServerIsRefused) {
  auto robot = options(keystore_, "/robot_1");
  robot.discovery_servers = {{.host = "127.0.0.1"}};
  EXPECT_THAT(error_of(robot), HasSubstr("unset ROS_DISCOVERY_SERVER"));
}

TEST_F(SecuredNetwork, WhatIsNotExportedStaysOnTheMachine) {
  auto robot = options(keystore_, "/robot_1");
  robot.exported_topics = std::set<std::string>{};
  auto command_line = options(keystore_, "/robot_2");
  command_line.hears_unexported = true;
  Peer from(robot);
  Peer station(options(keystore_, "/robot_3"));
  Peer inside(command_line);
  ASSERT_TRUE(from.written.await_matched(1));
  ASSERT_TRUE(inside.written.await_matched(2));
  ASSERT_TRUE(inside.read.await_matched(2));
  ASSERT_TRUE(station.read.await_matched(1));
  from.say("inside");
  ASSERT_TRUE(inside.read.await_messages(1));
  // What comes later from elsewhere is all that the station has.
  inside.say("to all");
  ASSERT_TRUE(station.read.await_messages(1));
  EXPECT_EQ(station.heard("inside"), 0U);
  EXPECT_EQ(station.heard("to all"), 1U);
}

/// As those of SROS 2, or of an older keystore.
TEST_F(SecuredNetwork, ExportNeedsPermissionsWithPartitions) {
  const fs::path permissions = keystore_ / "enclaves/robot_1/permissions.p7s";
  std::string document = keystore::to_permissions_xml(
      "/robot_1", nullptr, domain(), std::time(nullptr) - kDay, std::time(nullptr) + kDay);
  for (auto begin = document.find("<partitions>"); begin != std::string::npos;
       begin = document.find("<partitions>")) {
    constexpr std::string_view kEnd = "</partitions>";
    document.erase(begin, document.find(kEnd) + kEnd.size() - begin);
  }
  sign(document, permissions);
  auto robot = options(keystore_, "/robot_1");
  Peer runs(robot);
  robot.exported_topics = std::set<std::string>{};
  EXPECT_THAT(error_of(robot), HasSubstr("permissions.p7s: grants the default partition alone"));
}

}  // namespace
}  // namespace pipescout::security
