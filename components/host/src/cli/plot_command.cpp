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

struct OdometryOptions {
  std::string result;
  std::string out;
  std::string format = "svg";
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

int plot_odometry(const OdometryOptions& options) {
  // One word each, so that a path that begins with '-' stays one.
  std::vector<std::string> arguments{"odometry", "--format=" + options.format};
  if (!options.out.empty()) {
    arguments.push_back("--out=" + options.out);
  }
  if (!options.alignment.empty()) {
    arguments.push_back("--alignment=" + options.alignment);
  }
  arguments.insert(arguments.end(), {"--", options.result});
  draw(arguments);
}

}  // namespace

void add_plot_commands(CLI::App& app, Action& action) {
  auto* plot = app.add_subcommand("plot", "Draw pictures of what a mission recorded");
  plot->require_subcommand(1);

  auto options = std::make_shared<OdometryOptions>();
  auto* odometry = plot->add_subcommand(
      "odometry", "Odometers, welds and places in the pipe; prints the path of each picture");
  odometry
      ->add_option("result", options->result,
                   "Mission folder, or the JSON file of `pipescout reproduce in-pipe`")
      ->required();
  odometry->add_option("--out", options->out, "Folder of the pictures; default: RESULT/pictures");
  odometry->add_option("--format", options->format, "svg or png")
      ->check(CLI::IsMember({"svg", "png"}))
      ->capture_default_str();
  odometry->add_option("--alignment", options->alignment,
                       "What `pipescout ledger align --report` wrote; default: "
                       "RESULT/alignment.csv");
  odometry->callback([=, &action] { action = [=] { return plot_odometry(*options); }; });
}

}  // namespace pipescout::host
