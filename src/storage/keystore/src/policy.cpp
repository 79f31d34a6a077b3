// SPDX-License-Identifier: Apache-2.0
#include "pipescout/keystore/policy.hpp"

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "pipescout/keystore/certificates.hpp"
#include "pipescout/keystore/enclave_files.hpp"
#include "xml_includes.hpp"

namespace pipescout::keystore {
namespace {

constexpr std::string_view kRequestSuffix = "Request";

/// What a node of any kind has, by the name that follows the node's own.
constexpr std::string_view kDiscoveryTopic = "ros_discovery_info";

std::string required_attribute(const XmlElement& element, const char* name) {
  const char* const value = element.element->Attribute(name);
  if (value == nullptr || *value == '\0') {
    refuse(element, std::string("attribute '") + name + "' is missing");
  }
  return value;
}

struct Profile {
  std::string ns;
  std::string node;
};

std::string qualified(const Profile& profile, std::string name) {
  if (name.starts_with('/')) {
    return name;
  }
  const std::string base = profile.ns.ends_with('/') ? profile.ns : profile.ns + "/";
  if (name.starts_with('~')) {
    name.erase(0, name.starts_with("~/") ? 2 : 1);
    return base + profile.node + "/" + name;
  }
  return base + name;
}

void add_action(EnclavePolicy& policy, const std::string& name, bool executes) {
  for (const char* const service : {"send_goal", "cancel_goal", "get_result"}) {
    (executes ? policy.reply : policy.request).insert(name + "/_action/" + service);
  }
  for (const char* const topic : {"feedback", "status"}) {
    (executes ? policy.publish : policy.subscribe).insert(name + "/_action/" + topic);
  }
}

enum class Right { kPublish, kSubscribe, kReply, kRequest, kExecute, kCall };

void add_right(EnclavePolicy& policy, Right right, const std::string& name) {
  switch (right) {
    case Right::kPublish:
      policy.publish.insert(name);
      break;
    case Right::kSubscribe:
      policy.subscribe.insert(name);
      break;
    case Right::kReply:
      policy.reply.insert(name);
      break;
    case Right::kRequest:
      policy.request.insert(name);
      break;
    case Right::kExecute:
      add_action(policy, name, true);
      break;
    case Right::kCall:
      add_action(policy, name, false);
      break;
  }
}

struct RightName {
  const char* group;
  const char* element;
  const char* attribute;
  Right right;
};

constexpr std::array kRights{
    RightName{"topics", "topic", "publish", Right::kPublish},
    RightName{"topics", "topic", "subscribe", Right::kSubscribe},
    RightName{"services", "service", "reply", Right::kReply},
    RightName{"services", "service", "request", Right::kRequest},
    RightName{"actions", "action", "execute", Right::kExecute},
    RightName{"actions", "action", "call", Right::kCall},
};

void read_group(EnclavePolicy& policy, const Profile& profile, const XmlElement& group,
                XmlIncludes& files) {
  bool known = false;
  for (const auto& right : kRights) {
    const char* const rule = group.element->Attribute(right.attribute);
    if (group.name() != right.group || rule == nullptr) {
      continue;
    }
    known = true;
    if (std::string_view(rule) != "ALLOW") {
      refuse(group, std::string(right.attribute) + "=\"" + rule +
                        "\": only ALLOW can be granted; what no rule allows is denied");
    }
    for (const auto& entry : files.children(group)) {
      const char* const name = entry.element->GetText();
      if (entry.name() != right.element || name == nullptr) {
        refuse(entry, std::string("expected a <") + right.element + "> with a name");
      }
      add_right(policy, right.right, qualified(profile, name));
    }
  }
  if (!known) {
    refuse(group,
           "is no group of rights: topics, services or actions with publish, "
           "subscribe, reply, request, execute or call");
  }
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '&':
        result += "&amp;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string policy_group(const RightName& right, const std::set<std::string>& names) {
  if (names.empty()) {
    return {};
  }
  std::string text =
      std::string("          <") + right.group + " " + right.attribute + "=\"ALLOW\">\n";
  for (const auto& name : names) {
    text += std::string("            <") + right.element + ">" + escaped(name) + "</" +
            right.element + ">\n";
  }
  return text + "          </" + right.group + ">\n";
}

std::string xml_time(std::time_t time) {
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts)};
}

std::string criterion(const char* name, const std::set<std::string>& topics) {
  std::string text = std::string("        <") + name + ">\n          <topics>\n";
  for (const auto& topic : topics) {
    text += "            <topic>" + escaped(topic) + "</topic>\n";
  }
  return text + "          </topics>\n          <partitions>\n            <partition>" +
         std::string(kAnyPartition) + "</partition>\n          </partitions>\n        </" + name +
         ">\n";
}

}  // namespace

void add_endpoint(EnclavePolicy& policy, const std::string& dds_topic, bool is_writer) {
  if (dds_topic.starts_with("rt/")) {
    (is_writer ? policy.publish : policy.subscribe).insert(dds_topic.substr(2));
  } else if (dds_topic.starts_with("rq/") && dds_topic.ends_with(kRequestSuffix)) {
    const auto name = dds_topic.substr(2, dds_topic.size() - 2 - kRequestSuffix.size());
    (is_writer ? policy.request : policy.reply).insert(name);
  }
  // A reply follows from the request.
}

std::string to_policy_xml(const Policy& policy) {
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<policy version=\"0.2.0\">\n"
      "  <enclaves>\n";
  for (const auto& [name, rights] : policy) {
    const auto cut = name.rfind('/');
    const std::string ns = cut == 0 ? "/" : name.substr(0, cut);
    const std::string node = name.size() == 1 ? "root" : name.substr(cut + 1);
    xml += "    <enclave path=\"" + escaped(name) +
           "\">\n      <profiles>\n        <profile ns=\"" + escaped(ns) + "\" node=\"" +
           escaped(node) + "\">\n";
    xml += policy_group(kRights[0], rights.publish);
    xml += policy_group(kRights[1], rights.subscribe);
    xml += policy_group(kRights[2], rights.reply);
    xml += policy_group(kRights[3], rights.request);
    xml += "        </profile>\n      </profiles>\n    </enclave>\n";
  }
  return xml + "  </enclaves>\n</policy>\n";
}

Policy parse_policy(const std::string& xml, const std::string& path) {
  XmlIncludes files;
  const auto root = files.parse(xml, path);
  const auto enclaves =
      root.name() == "policy" ? files.children(root, "enclaves") : std::vector<XmlElement>{};
  if (enclaves.empty()) {
    throw KeystoreError(path + ": has no <policy> with <enclaves>");
  }
  Policy policy;
  for (const auto& list : enclaves) {
    for (const auto& enclave : files.children(list, "enclave")) {
      auto& rights = policy[required_attribute(enclave, "path")];
      const auto profiles = files.children(enclave, "profiles");
      if (profiles.empty()) {
        refuse(enclave, "has no <profiles>");
      }
      for (const auto& of_enclave : profiles) {
        for (const auto& profile : files.children(of_enclave, "profile")) {
          const Profile names{required_attribute(profile, "ns"),
                              required_attribute(profile, "node")};
          for (const auto& group : files.children(profile)) {
            read_group(rights, names, group, files);
          }
        }
      }
    }
  }
  return policy;
}

Policy read_policy(const std::filesystem::path& path) {
  return parse_policy(content_of(path), path.string());
}

std::string to_permissions_xml(const std::string& enclave, const EnclavePolicy* policy,
                               unsigned domain, std::time_t not_before, std::time_t not_after) {
  std::set<std::string> publish{std::string(kDiscoveryTopic)};
  std::set<std::string> subscribe = publish;
  if (policy == nullptr) {
    publish = {"*"};
    subscribe = {"*"};
  } else {
    for (const auto& name : policy->publish) {
      publish.insert("rt" + name);
    }
    for (const auto& name : policy->subscribe) {
      subscribe.insert("rt" + name);
    }
    for (const auto& name : policy->reply) {
      subscribe.insert("rq" + name + "Request");
      publish.insert("rr" + name + "Reply");
    }
    for (const auto& name : policy->request) {
      publish.insert("rq" + name + "Request");
      subscribe.insert("rr" + name + "Reply");
    }
  }
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name=")" +
         escaped(enclave) + "\">\n      <subject_name>CN=" + escaped(enclave) +
         "</subject_name>\n      <validity>\n        <not_before>" + xml_time(not_before) +
         "</not_before>\n        <not_after>" + xml_time(not_after) +
         "</not_after>\n      </validity>\n      <allow_rule>\n        <domains>\n          <id>" +
         std::to_string(domain) + "</id>\n        </domains>\n" + criterion("publish", publish) +
         criterion("subscribe", subscribe) +
         "      </allow_rule>\n      <default>DENY</default>\n    </grant>\n  </permissions>\n"
         "</dds>\n";
}

std::string to_governance_xml(unsigned domain) {
  // The submessages are encrypted, and with them the data; a second layer around the data would
  // only matter to a relay that may forward and not read.
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains>
        <id>)" +
         std::to_string(domain) +
         R"(</id>
      </domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";
}

}  // namespace pipescout::keystore
