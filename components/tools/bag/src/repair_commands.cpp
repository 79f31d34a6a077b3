// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>

#include "offline_commands.hpp"
#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "schema_comparison.hpp"
#include "storage_options.hpp"

namespace pipescout::bag_command {
namespace {

using command_line::Action;
using command_line::kExitError;
using command_line::kExitOk;

int check(const std::string& bag) {
  bags::BagReport report = bags::check_bag(bag);
  try {
    const bags::BagReader reader(bag);
    for (const bags::BagTopic& topic : reader.topics()) {
      if (const auto contradiction = schema_contradiction(topic)) {
        report.faults.push_back(*contradiction);
      }
    }
  } catch (const bags::BagError&) {
    // It is in the report.
  }
  for (const std::string& fault : report.faults) {
    std::cerr << "fault: " << fault << '\n';
  }
  for (const std::string& note : report.notes) {
    std::cerr << "note: " << note << '\n';
  }
  std::cout << bag << ": " << report.messages << " messages can be read";
  if (!report.faults.empty()) {
    std::cout << ", but not everything: " << report.faults.size()
              << (report.faults.size() == 1 ? " fault" : " faults");
  }
  std::cout << '\n';
  return report.faults.empty() ? kExitOk : kExitError;
}

int reindex(const std::string& bag) {
  const auto metadata = bags::reindex_bag(bag);
  std::cout << bag << ": metadata.yaml for " << metadata.messages << " messages on "
            << metadata.topics.size() << " topics in " << metadata.files.size() << " files\n";
  return kExitOk;
}

int recover(const std::string& bag, const StorageOptions& options) {
  const bags::Storage storage = bags::BagReader(bag).metadata().storage;
  const auto report = bags::recover_bag(bag, options.output, writer_options(options, storage));
  for (const std::string& fault : report.faults) {
    std::cerr << "lost: " << fault << '\n';
  }
  std::cout << options.output << ": " << report.messages << " messages recovered\n";
  return kExitOk;
}

}  // namespace

void add_repair_commands(CLI::App& app, Action& action) {
  auto bag = std::make_shared<std::string>();
  auto options = std::make_shared<StorageOptions>();
  const auto add = [&](const char* name, const char* description) {
    auto* command = app.add_subcommand(name, description);
    command->add_option("bag", *bag, "Folder of the bag, or one of its files")->required();
    return command;
  };
  add("check", "Read all of a bag; exits with 0 only if all of it can be read and agrees")
      ->callback([=, &action] { action = [=] { return check(*bag); }; });
  add("reindex", "Write metadata.yaml anew, from the files of a bag")->callback([=, &action] {
    action = [=] { return reindex(*bag); };
  });
  auto* recover_command =
      add("recover", "Write what can be read of a cut or damaged bag to a new one");
  add_storage_options(*recover_command, *options);
  recover_command->callback([=, &action] { action = [=] { return recover(*bag, *options); }; });
}

}  // namespace pipescout::bag_command
