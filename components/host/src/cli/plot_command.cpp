// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "cli/command.hpp"
#include "core/substitution.hpp"

namespace pipescout::host {
namespace {

constexpr const char* kPackage = "pipescout_plots";
constexpr const char* kPythonVariable = "PIPESCOUT_PYTHON";
// Not the first one of PATH: only Debian's own Python sees Debian's matplotlib.
constexpr const char* kDebianPython = "/usr/bin/python3";

/// Of every subject.
struct PlotOptions {
  std::string result;
  std::string out;
  std::string format = "svg";
};

struct OdometryOptions : PlotOptions {
  std::string alignment;
};

std::string python() {
  const char* chosen = std::getenv(kPythonVariable);
  return chosen != nullptr && *chosen != '\0' ? chosen : kDebianPython;
}

/// Becomes the program that draws, so that its exit code and what stops it are this command's.
[[noreturn]] void draw(const std::vector<std::string>& arguments) {
  const auto folder = installed_share_folder(kPackage);
  if (!folder) {
    throw CommandError(std::string("error: no installed package '") + kPackage +
                       "'; is its prefix in AMENT_PREFIX_PATH?");
  }
  const auto interpreter = python();
  // -B: nothing is written into the installation.
  std::vector<std::string> words{interpreter, "-B", *folder + "/plot.py"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (auto& word : words) {
    pointers.push_back(word.data());
  }
  pointers.push_back(nullptr);
  ::execv(interpreter.c_str(), pointers.data());
  throw CommandError("error: cannot run " + interpreter + ": " + std::strerror(errno) +
                     "; install the Debian package python3, or name another Python in " +
                     kPythonVariable);
}

/// `more`: options of the subject alone. One word each, so that a path that begins with '-' stays
/// one.
int draw_subject(const char* subject, const PlotOptions& options,
                 const std::vector<std::string>& more) {
  std::vector<std::string> arguments{subject, "--format=" + options.format};
  if (!options.out.empty()) {
    arguments.push_back("--out=" + options.out);
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  arguments.insert(arguments.end(), {"--", options.result});
  draw(arguments);
}

CLI::App* add_subject(CLI::App& parent, const char* name, const char* description,
                      const char* results, PlotOptions& options) {
  auto* subject = parent.add_subcommand(name, description);
  subject->add_option("result", options.result, results)->required();
  subject->add_option("--out", options.out, "Folder of the pictures; default: RESULT/pictures");
  subject->add_option("--format", options.format, "svg or png")
      ->check(CLI::IsMember({"svg", "png"}))
      ->capture_default_str();
  return subject;
}

void add_odometry(CLI::App& plot, Action& action) {
  auto options = std::make_shared<OdometryOptions>();
  auto* subject = add_subject(
      plot, "odometry", "Odometers, welds and places in the pipe; prints the path of each picture",
      "Mission folder, or the JSON file of `pipescout reproduce in-pipe`", *options);
  subject->add_option("--alignment", options->alignment,
                      "What `pipescout ledger align --report` wrote; default: "
                      "RESULT/alignment.csv");
  subject->callback([=, &action] {
    action = [=] {
      std::vector<std::string> more;
      if (!options->alignment.empty()) {
        more.push_back("--alignment=" + options->alignment);
      }
      return draw_subject("odometry", *options, more);
    };
  });
}

void add_rack(CLI::App& plot, Action& action) {
  auto options = std::make_shared<PlotOptions>();
  auto* subject =
      add_subject(plot, "rack", "Flights over a pipe rack; prints the path of each picture",
                  "Mission folder, or the JSON file of `pipescout reproduce rack`", *options);
  subject->callback([=, &action] { action = [=] { return draw_subject("rack", *options, {}); }; });
}

void add_estimator(CLI::App& plot, Action& action) {
  auto options = std::make_shared<PlotOptions>();
  auto* subject = add_subject(
      plot, "estimator", "A state estimator, and why it said so; prints the path of each picture",
      "Mission folder, or the JSON file of `pipescout reproduce estimator`", *options);
  subject->callback(
      [=, &action] { action = [=] { return draw_subject("estimator", *options, {}); }; });
}

void add_tracking(CLI::App& plot, Action& action) {
  auto options = std::make_shared<PlotOptions>();
  auto* subject = add_subject(
      plot, "tracking", "The track of a pipe, and the arm; prints the path of each picture",
      "Mission folder, or the JSON file of `pipescout reproduce tracking`", *options);
  subject->callback(
      [=, &action] { action = [=] { return draw_subject("tracking", *options, {}); }; });
}

}  // namespace

void add_plot_commands(CLI::App& app, Action& action) {
  auto* plot = app.add_subcommand("plot", "Draw pictures of what a mission recorded");
  plot->require_subcommand(1);
  add_odometry(*plot, action);
  add_rack(*plot, action);
  add_estimator(*plot, action);
  add_tracking(*plot, action);
}

}  // namespace pipescout::host
