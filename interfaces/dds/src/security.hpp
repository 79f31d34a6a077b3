// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include "event_thread.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "warnings.hpp"

/// DDS Security with the files of an enclave of a ROS 2 keystore. See docs/security.md.
namespace pipescout::dds {

/// The enclave that counts: that of `ROS_SECURITY_ENCLAVE_OVERRIDE` before that of the options.
[[nodiscard]] const std::string& effective_enclave(const DdsOptions& options);

/// Gives the participant authentication, access control and encryption, when the options ask for
/// it. Returns the revocation list, empty without one. With the strategy "permissive" an enclave
/// that lacks files is a warning and no security; a file that is there and cannot be used (not
/// readable, a private key that others can read, not valid at this time, revoked, signed by another
/// authority) is an error with every strategy. Throws TransportError naming the file, and the date
/// where time is the matter.
[[nodiscard]] std::filesystem::path apply_security(
    const DdsOptions& options, Warnings& warnings,
    eprosima::fastdds::dds::DomainParticipantQos& qos);

/// Looks at a revocation list every few seconds. Fast DDS reads it once, when a participant is
/// created, so that only another participant obeys one that has changed.
class RevocationWatch {
 public:
  /// `changed` is called once, in the thread of `events`. No watch without a file.
  RevocationWatch(EventThread& events, std::filesystem::path file, std::function<void()> changed);
  RevocationWatch(const RevocationWatch&) = delete;
  RevocationWatch& operator=(const RevocationWatch&) = delete;
  ~RevocationWatch();

 private:
  void look_later();

  EventThread& events_;
  const std::filesystem::path file_;
  const std::function<void()> changed_;
  const std::string content_;
};

}  // namespace pipescout::dds
