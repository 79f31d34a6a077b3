// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <ctime>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dds_test_support.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/keystore/keystore.hpp"

/// Secured participants of one keystore.
namespace pipescout::security {

inline constexpr std::time_t kDay = 24 * 3600;

inline std::uint32_t domain() {
  return dds_test::local_options().domain_id;
}

/// The only topic that the robots of `Secured` may use.
inline WireTopic secret_topic() {
  return {"rt/secret", &message_type<std_msgs::msg::String>()};
}

/// A process on the network that reads and writes the topic.
class Peer {
 public:
  explicit Peer(const DdsOptions& options)
      : transport_(create_dds_transport(options)),
        reader_(transport_->create_reader(secret_topic(), QoS::reliable(), read)),
        writer_(transport_->create_writer(secret_topic(), QoS::reliable(), written)) {}

  void say(const std::string& text) {
    const auto message = dds_test::make_text(text);
    (void)writer_->write(&message, {});
  }
  [[nodiscard]] std::vector<std::string> warnings() const { return transport_->warnings(); }
  [[nodiscard]] std::size_t heard(const std::string& text) {
    std::size_t count = 0;
    for (const auto& received : read.monitor.copy(read.messages)) {
      count += static_cast<const std_msgs::msg::String*>(received.message.get())->data == text;
    }
    return count;
  }

  dds_test::ReaderRecord read;
  dds_test::WriterRecord written;

 private:
  std::unique_ptr<Transport> transport_;
  std::unique_ptr<TransportReader> reader_;
  std::unique_ptr<TransportWriter> writer_;
};

/// Three robots, "/robot_1" to "/robot_3", of one keystore.
class Secured : public ::testing::Test {
 protected:
  Secured() {
    make_keystore(keystore_);
    add(keystore_, "/robot_1");
    add(keystore_, "/robot_2");
    add(keystore_, "/robot_3");
  }

  static void make_keystore(const std::filesystem::path& keystore) {
    keystore::create_keystore(keystore, domain(), 3650, std::time(nullptr) - 1000 * kDay);
  }
  static void add(const std::filesystem::path& keystore, const std::string& name,
                  std::time_t at = std::time(nullptr)) {
    keystore::EnclavePolicy policy;
    policy.publish = {"/secret"};
    policy.subscribe = {"/secret"};
    keystore::create_enclave(keystore, {.name = name, .domain = domain(), .policy = policy}, at);
  }
  static DdsOptions options(const std::filesystem::path& keystore, const std::string& enclave) {
    auto result = dds_test::local_options();
    result.enclave = enclave;
    result.security.enabled = true;
    result.security.enforce = true;
    result.security.keystore = keystore;
    result.security.on_revocations_changed = [] {};
    return result;
  }
  static std::string error_of(const DdsOptions& options) {
    try {
      (void)create_dds_transport(options);
    } catch (const TransportError& error) {
      return error.what();
    }
    return "no error";
  }

  ::pipescout::testing::TemporaryFolder folder_;
  const std::filesystem::path keystore_ = folder_.path() / "keystore";
};

}  // namespace pipescout::security
