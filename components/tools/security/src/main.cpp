// SPDX-License-Identifier: Apache-2.0
#include <ctime>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "observation.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/command_line/text_table.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/keystore/keystore.hpp"

namespace pipescout::security {
namespace {

using command_line::Action;
using command_line::CommandError;
using command_line::kExitError;
using command_line::kExitOk;
using keystore::Finding;

constexpr int kDaysOfAuthorities = 3650;
constexpr int kDaysOfEnclaves = 365;
constexpr int kWarnDays = 30;

struct Options {
  std::string keystore;
  std::string enclave;
  std::string policy;
  std::vector<std::string> composition;
  std::string ns;
  unsigned domain = 0;
  int days = kDaysOfEnclaves;
  int authority_days = kDaysOfAuthorities;
  int warn_days = kWarnDays;
  bool renew = false;
  bool json = false;
  bool strict_keys = false;
};

/// Keys of authorities that others can read, as SROS 2 makes them.
void check_authority_keys(const Options& options) {
  for (const auto& exposed : keystore::exposed_authority_keys(options.keystore)) {
    if (options.strict_keys) {
      throw CommandError(exposed);
    }
    std::cerr << "warning: " << exposed << "\n";
  }
}

int create_enclave(const Options& options) {
  check_authority_keys(options);
  keystore::EnclaveRequest request{.name = options.enclave,
                                   .domain = options.domain,
                                   .days = options.days,
                                   .renew = options.renew,
                                   .policy = std::nullopt};
  if (options.policy.empty()) {
    std::cerr << "note: without --policy the enclave may use every topic\n";
  } else {
    const auto policy = keystore::read_policy(options.policy);
    const auto rights = policy.find(options.enclave);
    if (rights == policy.end()) {
      throw CommandError(options.policy + ": has no enclave '" + options.enclave + "'");
    }
    request.policy = rights->second;
  }
  keystore::create_enclave(options.keystore, request, std::time(nullptr));
  std::cout << "made enclave " << options.enclave << "\n";
  return kExitOk;
}

int generate_policy(const Options& options) {
  command_line::require_new_file(options.policy);
  replace_file(options.policy, keystore::to_policy_xml(observe({.composition = options.composition,
                                                                .ns = options.ns,
                                                                .enclave = options.enclave})));
  std::cout << "wrote " << options.policy << "\n";
  return kExitOk;
}

const char* word(Finding::Severity severity) {
  return severity == Finding::Severity::kOk        ? "ok"
         : severity == Finding::Severity::kWarning ? "warning"
                                                   : "ERROR";
}

int check(const Options& options) {
  const auto findings =
      keystore::check(options.keystore, options.warn_days, std::time(nullptr), options.strict_keys);
  bool failed = false;
  command_line::TextTable table({"", "file", ""});
  auto json = nlohmann::json::array();
  for (const auto& finding : findings) {
    failed |= finding.severity == Finding::Severity::kError;
    table.add_row({std::string(word(finding.severity)), finding.file, finding.text});
    auto& entry = json.emplace_back(nlohmann::json{
        {"severity", word(finding.severity)}, {"file", finding.file}, {"text", finding.text}});
    if (finding.not_after) {
      entry["not_after"] = keystore::date_text(*finding.not_after);
    }
  }
  if (options.json) {
    std::cout << json.dump(2) << "\n";
  } else {
    table.print(std::cout);
  }
  return failed ? kExitError : kExitOk;
}

CLI::App* add_command(CLI::App& app, Options& options, const char* name, const char* description) {
  auto* const command = app.add_subcommand(name, description);
  command->add_option("keystore", options.keystore, "Folder of the keystore")->required();
  return command;
}

void add_domain(CLI::App& command, Options& options) {
  constexpr unsigned kHighestDomain = 232;
  command.add_option("--domain", options.domain, "DDS domain that it is for")
      ->check(CLI::Range(0U, kHighestDomain))
      ->envname("ROS_DOMAIN_ID")
      ->capture_default_str();
}

void add_strict_keys(CLI::App& command, Options& options) {
  command
      .add_flag(
          "--strict-keys", options.strict_keys,
          "Refuse private keys that others than their owner can read; else they are warned of")
      ->envname("PIPESCOUT_STRICT_KEYS");
}

void add_commands(CLI::App& app, Action& action) {
  app.require_subcommand(1);
  auto options = std::make_shared<Options>();

  auto* create = add_command(app, *options, "create-keystore",
                             "Make a keystore: an authority for identities, another for "
                             "permissions, and the governance");
  create->add_option("--days", options->authority_days, "Validity of the authorities, in days")
      ->capture_default_str();
  add_domain(*create, *options);
  create->callback([=, &action] {
    action = [=] {
      keystore::create_keystore(options->keystore, options->domain, options->authority_days,
                                std::time(nullptr));
      std::cout << "made keystore " << options->keystore << "\n";
      return kExitOk;
    };
  });

  auto* enclave = add_command(app, *options, "create-enclave",
                              "Make key, certificate and permissions of an enclave");
  enclave->add_option("enclave", options->enclave, "Name, such as /robot_1")->required();
  enclave->add_option("--policy", options->policy, "What it may do, XML of SROS 2");
  enclave->add_option("--days", options->days, "Validity, in days")->capture_default_str();
  enclave->add_flag("--renew", options->renew, "Replace those of an enclave that exists");
  add_domain(*enclave, *options);
  add_strict_keys(*enclave, *options);
  enclave->callback([=, &action] { action = [=] { return create_enclave(*options); }; });

  auto* generate = app.add_subcommand(
      "generate-policy", "Write what a composition, or all that runs in the domain, uses");
  generate->add_option("policy", options->policy, "The policy, XML of SROS 2")->required();
  generate->add_option("--enclave", options->enclave,
                       "Put all into this enclave, not into those that the processes announce");
  auto* const composition =
      generate
          ->add_option("--composition", options->composition,
                       "Run this composition (file, and NAME:=VALUE) and observe it")
          ->expected(1, CLI::detail::expected_max_vector_size);
  generate
      ->add_option("--namespace", options->ns,
                   "Namespace in which the composition runs, such as /robot_1")
      ->needs(composition);
  generate->callback([=, &action] { action = [=] { return generate_policy(*options); }; });

  auto* revoke = add_command(app, *options, "revoke", "Revoke the certificate of an enclave");
  revoke->add_option("enclave", options->enclave, "Name, such as /robot_1")->required();
  add_strict_keys(*revoke, *options);
  revoke->callback([=, &action] {
    action = [=] {
      check_authority_keys(*options);
      keystore::revoke(options->keystore, options->enclave, std::time(nullptr));
      std::cout << "revoked " << options->enclave
                << "; copy public/identity_ca.crl.pem to the robots that have a copy\n";
      return kExitOk;
    };
  });

  auto* list = add_command(app, *options, "list", "Names of the enclaves");
  list->callback([=, &action] {
    action = [=] {
      for (const auto& name : keystore::list_enclaves(options->keystore)) {
        std::cout << name << "\n";
      }
      return kExitOk;
    };
  });

  auto* check_command =
      add_command(app, *options, "check",
                  "Look at all files: there, signed, valid, revoked, keys for their owner alone");
  check_command
      ->add_option("--warn-days", options->warn_days, "Warn of what ends within so many days")
      ->check(CLI::Range(0, 36500))
      ->capture_default_str();
  check_command->add_flag("--json", options->json, "Print JSON");
  add_strict_keys(*check_command, *options);
  check_command->callback([=, &action] { action = [=] { return check(*options); }; });
}

}  // namespace
}  // namespace pipescout::security

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout security",
                                               pipescout::security::add_commands, argc, argv);
}
