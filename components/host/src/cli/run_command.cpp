// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "cli/command.hpp"
#include "run/run.hpp"

namespace pipescout::host {

void add_run_command(CLI::App& app, Action& action) {
  struct RunCommandOptions {
    RunOptions run;
    ReplayOptions replay;
    std::string isolated_component;
    int control_fd = -1;
  };
  auto options = std::make_shared<RunCommandOptions>();
  auto* command = app.add_subcommand(
      "run", "Run a composition until it is complete or stopped (SIGINT, SIGTERM)");
  command->add_option("composition", options->run.composition, "Composition file (YAML)")
      ->required();
  command->add_option("arguments", options->run.arguments,
                      "Arguments of the composition, NAME:=VALUE");
  command
      ->add_option("--namespace", options->run.ns, "Namespace of all components, such as /robot_1")
      ->capture_default_str();
  command
      ->add_option("-p,--param", options->run.parameters,
                   "A parameter: NAME:=VALUE for every component that has it, or "
                   "COMPONENT.NAME:=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      ->add_option("--params-file", options->run.parameter_files,
                   "Parameter file (ROS 2 YAML); may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->run.out,
                      "Mission folder; default: missions/<name>_<UTC time>");
  command->add_option("--enclave", options->run.enclave,
                      "Enclave of DDS Security for all components; default: /");
  auto* bag = command->add_option(
      "--bag", options->replay.bag,
      "Feed the components with this recording, in simulated time and without the network");
  command
      ->add_option("--record", options->replay.record,
                   "With --bag: record what the components publish into this new bag (MCAP)")
      ->needs(bag);
  command
      ->add_option("--rate", options->replay.rate,
                   "With --bag: seconds of the recording per second; default: as fast as they go")
      ->check(CLI::Range(1e-6, 1e6))
      ->needs(bag);
  // How a host starts the process of an isolated component; nothing for people.
  command->add_option("--isolated-component", options->isolated_component)->group("");
  command->add_option("--control-fd", options->control_fd)->group("");
  command->callback([options, &action] {
    action = [options] {
      if (!options->replay.bag.empty()) {
        return replay_composition(options->run, options->replay);
      }
      return options->isolated_component.empty()
                 ? run_composition(options->run)
                 : run_isolated(options->run, options->isolated_component, options->control_fd);
    };
  });
}

}  // namespace pipescout::host
