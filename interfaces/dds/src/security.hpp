// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
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

struct AppliedSecurity {
  std::filesystem::path revocations;  ///< the list that counts; empty: there is none
  bool may_use_any_partition = true;  ///< else the default one alone
  /// Of the largest message by which participants authenticate each other, which Fast DDS sends in
  /// one datagram or not at all; 0 without security.
  std::uint32_t handshake_bytes = 0;
};

/// Gives the participant authentication, access control and encryption, when the options ask for
/// it. With the strategy "permissive" an enclave that lacks files is a warning and no security; a
/// file that is there and cannot be used (not readable, not valid at this time, for another domain,
/// revoked, signed by another authority, without the partitions that exported topics need) is an
/// error with every strategy, and so is a discovery server, over which secured participants of this
/// Fast DDS do not find each other. A private key that others can read is a warning, with
/// `strict_keys` an error. Throws TransportError naming the file, and
/// the date where time is the matter.
[[nodiscard]] AppliedSecurity apply_security(const DdsOptions& options, Warnings& warnings,
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
