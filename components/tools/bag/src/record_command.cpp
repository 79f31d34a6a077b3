// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "live_commands.hpp"
#include "live_component.hpp"

namespace pipescout::bag_command {
namespace {

struct Options {
  std::vector<std::string> topics;
  bool all = false;
  std::string regex;
  std::string exclude;
  std::string output;
  std::string storage = "sqlite3";
  std::int64_t max_bag_size = 0;
  std::int64_t max_bag_duration = 0;
  std::int64_t max_cache_size = 100 * 1024 * 1024;
  std::string compression_mode = "none";
  std::string compression_format = "zstd";
  std::string qos_overrides;
  bool snapshot_mode = false;
  bool use_sim_time = false;
  bool hidden = false;
};

int record(const Options& options) {
  if (!options.all && options.topics.empty() && options.regex.empty()) {
    throw command_line::CommandError("Must specify topics, --all or --regex");
  }
  if (options.all && !options.topics.empty()) {
    throw command_line::CommandError("Must specify only one option out of topics and --all");
  }
  return run_live(
      {.class_name = "pipescout::BagRecorder",
       // As rosbag2's, so that its services are where they are looked for.
       .node_name = "rosbag2_recorder",
       .parameters = {override_of("topics", options.topics), override_of("all", options.all),
                      override_of("regex", options.regex), override_of("exclude", options.exclude),
                      override_of("output", options.output),
                      override_of("storage", options.storage),
                      override_of("max_bag_size", options.max_bag_size),
                      override_of("max_bag_duration", options.max_bag_duration),
                      override_of("max_cache_size", options.max_cache_size),
                      override_of("compression_mode", options.compression_mode),
                      override_of("qos_overrides", options.qos_overrides),
                      override_of("snapshot_mode", options.snapshot_mode),
                      override_of("use_sim_time", options.use_sim_time),
                      override_of("include_hidden_topics", options.hidden)}});
}

}  // namespace

void add_record_command(CLI::App& app, command_line::Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "record", "Record topics into a bag until it is stopped (SIGINT, SIGTERM)");
  command->add_option("topics", options->topics, "Topics to record");
  command->add_flag("-a,--all", options->all, "Record all topics");
  command->add_option("-e,--regex", options->regex,
                      "Record the topics in whose names this is found, in place of --all");
  command->add_option("-x,--exclude", options->exclude,
                      "Do not record the topics in whose names this is found");
  command->add_option("-o,--output", options->output,
                      "Folder of the bag; default: rosbag2_<local time>");
  command->add_option("-s,--storage", options->storage, "How files are written")
      ->check(CLI::IsMember({"sqlite3", "mcap"}))
      ->capture_default_str();
  command
      ->add_option("-b,--max-bag-size", options->max_bag_size,
                   "Bytes of a file before another is begun; 0: no limit")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("-d,--max-bag-duration", options->max_bag_duration,
                   "Seconds of a file before another is begun; 0: no limit")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--max-cache-size", options->max_cache_size,
                   "Bytes of messages that wait to be written; with --snapshot-mode those that are "
                   "kept")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--compression-mode", options->compression_mode, "What is compressed")
      ->check(CLI::IsMember({"none", "file", "message"}))
      ->capture_default_str();
  command->add_option("--compression-format", options->compression_format, "How")
      ->check(CLI::IsMember({"zstd"}))
      ->capture_default_str();
  command->add_option("--qos-profile-overrides-path", options->qos_overrides,
                      "File with QoS profiles by topic (YAML)");
  command->add_flag("--snapshot-mode", options->snapshot_mode,
                    "Write only when the service ~/snapshot asks for it");
  command->add_flag("--use-sim-time", options->use_sim_time, "Stamps are the time of /clock");
  command->add_flag("--include-hidden-topics", options->hidden,
                    "Topics with a part that begins with '_' too");
  command->callback([options, &action] { action = [options] { return record(*options); }; });
}

}  // namespace pipescout::bag_command
