// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cstdint>
#include <iostream>
#include <memory>
#include <rosbag2_interfaces/srv/get_rate.hpp>
#include <rosbag2_interfaces/srv/is_paused.hpp>
#include <rosbag2_interfaces/srv/play_next.hpp>
#include <rosbag2_interfaces/srv/set_rate.hpp>
#include <rosbag2_interfaces/srv/toggle_paused.hpp>
#include <string>
#include <utility>
#include <vector>

#include "keyboard.hpp"
#include "live_commands.hpp"
#include "live_component.hpp"

namespace pipescout::bag_command {
namespace {

namespace srv = rosbag2_interfaces::srv;

/// As rosbag2's, so that its services are where they are looked for.
constexpr const char* kNodeName = "rosbag2_player";
constexpr double kDefaultClockFrequency = 40.0;
/// s without anything new: two of the announcements that a participant makes once a second.
constexpr double kDefaultWait = 2.0;
/// By which the keys change the rate.
constexpr double kRateStep = 1.1;

struct Options {
  std::string bag;
  double rate = 1.0;
  bool loop = false;
  double start_offset = 0.0;
  std::string clock;  ///< Hz, or empty: the default frequency
  bool has_clock = false;
  double delay = 0.0;
  std::string wait;  ///< s, or empty: the default
  bool has_wait = false;
  std::vector<std::string> remap;
  std::vector<std::string> topics;
  std::int64_t read_ahead = 1000;
  std::string qos_overrides;
  bool start_paused = false;
  bool no_keyboard = false;
};

/// Turns keys into calls of the player's services.
class KeyboardControl {
 public:
  explicit KeyboardControl(Node& node)
      : node_(node),
        toggle_(client<srv::TogglePaused>("toggle_paused")),
        is_paused_(client<srv::IsPaused>("is_paused")),
        next_(client<srv::PlayNext>("play_next")),
        get_rate_(client<srv::GetRate>("get_rate")),
        set_rate_(client<srv::SetRate>("set_rate")),
        keyboard_(STDIN_FILENO,
                  [this](Key key) { node_.default_group()->post([this, key] { press(key); }); }) {
    std::cout << "space: pause and resume; right: next message while paused; up, down: rate\n"
              << std::flush;
  }

 private:
  template <class S>
  Client<S> client(const std::string& name) {
    return node_.create_client<S>("/" + std::string(kNodeName) + "/" + name);
  }

  void press(Key key) {
    switch (key) {
      case Key::kSpace:
        toggle_.call({}, [this](auto answer) {
          if (answer) {
            is_paused_.call({}, [](auto state) {
              if (state) {
                std::cout << (state->paused ? "paused\n" : "playing\n") << std::flush;
              }
            });
          }
        });
        break;
      case Key::kRight:
        next_.call({}, [](auto answer) {
          if (answer && !answer->success) {
            std::cout << "no next message: not paused, or at the end\n" << std::flush;
          }
        });
        break;
      case Key::kUp:
        change_rate(kRateStep);
        break;
      case Key::kDown:
        change_rate(1.0 / kRateStep);
        break;
    }
  }

  void change_rate(double factor) {
    get_rate_.call({}, [this, factor](auto answer) {
      if (!answer) {
        return;
      }
      srv::SetRate::Request request;
      request.rate = answer->rate * factor;
      set_rate_.call(request, [rate = request.rate](auto done) {
        if (done && done->success) {
          std::cout << "rate " << rate << '\n' << std::flush;
        }
      });
    });
  }

  Node& node_;
  Client<srv::TogglePaused> toggle_;
  Client<srv::IsPaused> is_paused_;
  Client<srv::PlayNext> next_;
  Client<srv::GetRate> get_rate_;
  Client<srv::SetRate> set_rate_;
  Keyboard keyboard_;
};

/// Of an option that may stand without its number; 0 where it is not given.
double number_of(const char* option, bool is_given, const std::string& text, double otherwise,
                 const char* what) {
  if (!is_given || text.empty()) {
    return is_given ? otherwise : 0.0;
  }
  double number = 0.0;
  if (!CLI::detail::lexical_cast(text, number) || !(number > 0.0)) {
    throw command_line::CommandError(std::string(option) + ": '" + text + "' is no " + what);
  }
  return number;
}

int play(const Options& options) {
  RemapRules remap_rules;
  for (const auto& rule : options.remap) {
    remap_rules.push_back(RemapRule::parse(rule));
  }
  LiveComponent live{
      .class_name = "pipescout::BagPlayer",
      .node_name = kNodeName,
      .parameters = {override_of("bag", options.bag), override_of("rate", options.rate),
                     override_of("loop", options.loop),
                     override_of("start_offset", options.start_offset),
                     override_of("clock_frequency",
                                 number_of("--clock", options.has_clock, options.clock,
                                           kDefaultClockFrequency, "frequency")),
                     override_of("delay", options.delay),
                     override_of("wait", number_of("--wait", options.has_wait, options.wait,
                                                   kDefaultWait, "time in s")),
                     override_of("topics", options.topics),
                     override_of("read_ahead_queue_size", options.read_ahead),
                     override_of("qos_overrides", options.qos_overrides),
                     override_of("start_paused", options.start_paused)},
      .remap_rules = std::move(remap_rules)};
  if (!options.no_keyboard && isatty(STDIN_FILENO) == 1) {
    live.attend = [](Node& node) { return std::make_shared<KeyboardControl>(node); };
  }
  return run_live(std::move(live));
}

}  // namespace

void add_play_command(CLI::App& app, command_line::Action& action) {
  auto options = std::make_shared<Options>();
  auto* command =
      app.add_subcommand("play", "Publish what a bag holds, in its order and at its pace");
  command->add_option("bag", options->bag, "Folder of the bag, or a .db3, .mcap or .bag file")
      ->required();
  command->add_option("-r,--rate", options->rate, "Seconds of the bag per second")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  command->add_flag("-l,--loop", options->loop, "Begin again after the last message");
  command
      ->add_option("--start-offset", options->start_offset,
                   "Seconds of the bag that are left out at its beginning")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  auto* clock = command
                    ->add_option("--clock", options->clock,
                                 "Publish the bag's time on /clock, at this frequency in Hz; "
                                 "without a number 40")
                    ->expected(0, 1);
  command->add_option("--delay", options->delay, "Seconds before the first message")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  auto* wait =
      command
          ->add_option("--wait", options->wait,
                       "Begin when all subscriptions that are there are matched, and nothing new "
                       "has appeared for so many seconds; without a number 2")
          ->expected(0, 1);
  command->add_option("-m,--remap", options->remap, "Names of topics, OLD:=NEW")->expected(1, -1);
  command->add_option("--topics", options->topics, "Play only these")->expected(1, -1);
  command
      ->add_option("--read-ahead-queue-size", options->read_ahead, "Messages that are read ahead")
      ->check(command_line::count_range())
      ->capture_default_str();
  command->add_option("--qos-profile-overrides-path", options->qos_overrides,
                      "File with QoS profiles by topic (YAML)");
  command->add_flag("-p,--start-paused", options->start_paused, "Begin paused");
  command->add_flag("--disable-keyboard-controls", options->no_keyboard,
                    "Leave the terminal's keys alone");
  command->callback([options, clock, wait, &action] {
    options->has_clock = clock->count() > 0;
    options->has_wait = wait->count() > 0;
    action = [options] { return play(*options); };
  });
}

}  // namespace pipescout::bag_command
