// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>
#include <filesystem>
#include <map>
#include <set>
#include <string>

/// What the processes of an enclave may do, in SROS 2's policy XML and in the permissions of DDS
/// Security.
namespace pipescout::keystore {

/// Fully qualified ROS names, which may hold the wildcards of fnmatch.
struct EnclavePolicy {
  std::set<std::string> publish;
  std::set<std::string> subscribe;
  std::set<std::string> reply;    ///< services that it serves
  std::set<std::string> request;  ///< services that it calls
  bool operator==(const EnclavePolicy&) const = default;
};

/// By the name of the enclave, "/robot_1".
using Policy = std::map<std::string, EnclavePolicy>;

/// An endpoint by its DDS topic, "rt/weld", "rq/getRequest". Adds what it needs; names that are not
/// of ROS, and what every enclave may do, add nothing.
void add_endpoint(EnclavePolicy& policy, const std::string& dds_topic, bool is_writer);

/// SROS 2's policy (version 0.2.0), one profile per enclave. Actions are written as their services
/// and topics.
[[nodiscard]] std::string to_policy_xml(const Policy& policy);

/// Reads such a policy, also one of SROS 2 with several profiles per enclave, relative names and
/// actions. Throws KeystoreError naming file and line for what is malformed, and for rules that
/// deny: permissions here allow, and deny everything else.
[[nodiscard]] Policy parse_policy(const std::string& xml, const std::string& path);
[[nodiscard]] Policy read_policy(const std::filesystem::path& path);

/// Permissions (DDS Security 1.1, 9.4.1.3) of one grant. `policy`: nullptr allows every topic, as
/// SROS 2 does for an enclave without a policy. Every enclave may use "ros_discovery_info". Topics
/// are granted in every partition: these keep data on a machine, and are no matter of rights.
[[nodiscard]] std::string to_permissions_xml(const std::string& enclave,
                                             const EnclavePolicy* policy, unsigned domain,
                                             std::time_t not_before, std::time_t not_after);

/// Governance (9.4.1.2): participants without an identity and permissions do not join, and all that
/// is sent, discovery included, is encrypted.
[[nodiscard]] std::string to_governance_xml(unsigned domain);

}  // namespace pipescout::keystore
