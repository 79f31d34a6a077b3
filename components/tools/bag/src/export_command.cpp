// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "offline_commands.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/idl/message_type.hpp"
#include "schema_comparison.hpp"
#include "storage_options.hpp"
#include "topic_export.hpp"

namespace pipescout::bag_command {
namespace {

namespace fs = std::filesystem;
using command_line::Action;
using command_line::CommandError;

struct ExportOptions {
  std::string bag;
  std::string output;
  TopicOptions topics;
  bool csv = false;
  bool tum = false;
  std::string images;
  std::size_t array_limit = 64;
};

/// What becomes of one topic.
struct TopicExport {
  const MessageType* type = nullptr;
  std::string name;
  std::shared_ptr<void> message;
  std::uint64_t undecoded = 0;
  std::optional<FlatFields> fields;
  std::unique_ptr<TextFile> csv;
  std::optional<ImageExport> images;
  std::optional<TrajectoryExport> trajectory;
  std::vector<std::string> cells;
};

std::string join(const std::vector<std::string>& cells) {
  std::string line;
  for (const std::string& cell : cells) {
    line += (line.empty() && &cell == &cells.front() ? "" : ",") + cell;
  }
  return line;
}

class Exporter {
 public:
  explicit Exporter(const ExportOptions& options) : options_(options), reader_(options.bag) {}

  int run() {
    const auto chosen = chosen_topics(options_.topics, reader_.topics());
    reader_.set_filter({.topics = chosen});
    fs::create_directories(options_.output);
    for (const bags::BagTopic& topic : reader_.topics()) {
      const bool wanted =
          !chosen || std::find(chosen->begin(), chosen->end(), topic.name) != chosen->end();
      exports_.push_back(wanted ? prepare(topic) : TopicExport{});
    }
    if (options_.csv) {
      each_message([](TopicExport& each, const bags::BagMessage&) {
        if (each.fields) {
          each.fields->observe({each.type, each.message.get()});
        }
      });
      begin_tables();
      reader_.set_filter({.topics = chosen});
    }
    each_message(
        [this](TopicExport& each, const bags::BagMessage& message) { write(each, message); });
    return finish();
  }

 private:
  TopicExport prepare(const bags::BagTopic& topic) {
    TopicExport result;
    if (const auto contradiction = schema_contradiction(topic)) {
      fail(*contradiction);
      return result;
    }
    result.type = topic.serialization_format == "cdr" ? find_message_type(topic.type) : nullptr;
    if (result.type == nullptr) {
      fail(topic.name + ": messages of " + topic.type + " (" + topic.serialization_format +
           ") are not known here");
      return result;
    }
    result.message = result.type->create();
    result.name = file_name_of(topic.name);
    while (!names_.insert(result.name).second) {
      result.name += '_';
    }
    if (options_.csv) {
      result.fields.emplace(*result.type, options_.array_limit);
    }
    if (!options_.images.empty() && ImageExport::takes(topic.type)) {
      result.images.emplace(fs::path(options_.output) / result.name, options_.images);
    }
    if (options_.tum && TrajectoryExport::takes(topic.type)) {
      result.trajectory.emplace(fs::path(options_.output) / result.name);
    }
    return result;
  }

  void fail(const std::string& message) {
    std::cerr << "error: " << message << '\n';
    failed_ = true;
  }

  template <class Use>
  void each_message(Use use) {
    for (TopicExport& each : exports_) {
      each.undecoded = 0;
    }
    while (const auto message = reader_.next_before_damage(damage_)) {
      TopicExport& each = exports_.at(message->topic);
      if (each.type == nullptr) {
        continue;
      }
      if (!each.type->deserialize(message->data, each.message.get())) {
        ++each.undecoded;
        continue;
      }
      use(each, *message);
    }
  }

  void begin_tables() {
    for (TopicExport& each : exports_) {
      if (each.fields) {
        each.csv = std::make_unique<TextFile>(fs::path(options_.output) / (each.name + ".csv"));
        std::vector<std::string> columns = each.fields->columns();
        columns.insert(columns.begin(), "log_time");
        each.csv->write(join(columns));
      }
    }
  }

  void write(TopicExport& each, const bags::BagMessage& message) {
    const MessageView view{each.type, each.message.get()};
    if (each.csv) {
      constexpr std::int64_t kSecond = 1'000'000'000;
      std::ostringstream time;
      time << message.log_time / kSecond << '.' << std::setw(9) << std::setfill('0')
           << message.log_time % kSecond;
      each.cells.assign(1, time.str());
      each.fields->cells(view, each.cells);
      each.csv->write(join(each.cells));
    }
    if (each.trajectory) {
      each.trajectory->write(view);
    }
    if (each.images) {
      try {
        each.images->write(view);
      } catch (const CommandError& error) {
        fail(reader_.topics().at(message.topic).name + ": " + error.what());
        each.images.reset();
      }
    }
  }

  int finish() {
    std::size_t tables = 0;
    std::size_t trajectories = 0;
    std::uint64_t images = 0;
    for (std::size_t k = 0; k < exports_.size(); ++k) {
      TopicExport& each = exports_[k];
      if (each.csv) {
        each.csv->close();
        ++tables;
      }
      trajectories += each.trajectory ? each.trajectory->close() : 0;
      images += each.images ? each.images->count() : 0;
      if (each.undecoded > 0) {
        fail(reader_.topics()[k].name + ": " + std::to_string(each.undecoded) +
             " messages are no " + std::string(each.type->name));
      }
    }
    if (!damage_.empty()) {
      fail("not everything could be read: " + damage_);
    }
    std::cout << options_.output << ": " << tables << " tables, " << trajectories
              << " trajectories, " << images << " images\n";
    return failed_ ? command_line::kExitError : command_line::kExitOk;
  }

  const ExportOptions& options_;
  bags::BagReader reader_;
  std::vector<TopicExport> exports_;
  std::set<std::string> names_;
  std::string damage_;
  bool failed_ = false;
};

}  // namespace

void add_export_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ExportOptions>();
  auto* command = app.add_subcommand(
      "export", "Write a bag as tables (CSV), images and trajectories (TUM); all three by default");
  command->add_option("bag", options->bag, "Folder of the bag, or one .db3, .mcap or .bag file")
      ->required();
  command->add_option("-o,--output", options->output, "New folder for the files")->required();
  add_topic_options(*command, options->topics);
  command->add_flag("--csv", options->csv, "A table for each topic, a column for each field");
  command->add_flag("--tum", options->tum,
                    "A trajectory for each topic of poses, and for each child frame of transforms");
  command->add_option("--images", options->images, "A file for each image: png or tiff")
      ->check(CLI::IsMember({"png", "tiff"}));
  command
      ->add_option("--array-limit", options->array_limit,
                   "Of sequences that are longer only the length goes to the table")
      ->check(CLI::Range(std::size_t{0}, std::size_t{100'000}));
  command->callback([=, &action] {
    if (!options->csv && !options->tum && options->images.empty()) {
      options->csv = true;
      options->tum = true;
      options->images = "png";
    }
    action = [=] {
      command_line::require_new_folder(options->output);
      return Exporter(*options).run();
    };
  });
}

}  // namespace pipescout::bag_command
