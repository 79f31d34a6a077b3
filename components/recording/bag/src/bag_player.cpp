// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_recording/bag_player.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <rosbag2_interfaces/srv/burst.hpp>
#include <rosbag2_interfaces/srv/get_rate.hpp>
#include <rosbag2_interfaces/srv/is_paused.hpp>
#include <rosbag2_interfaces/srv/pause.hpp>
#include <rosbag2_interfaces/srv/play_next.hpp>
#include <rosbag2_interfaces/srv/resume.hpp>
#include <rosbag2_interfaces/srv/seek.hpp>
#include <rosbag2_interfaces/srv/set_rate.hpp>
#include <rosbag2_interfaces/srv/toggle_paused.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/bag_topics/qos_profiles.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "playback_clock.hpp"
#include "read_ahead.hpp"
#include "subscription_wait.hpp"

namespace pipescout {

namespace srv = rosbag2_interfaces::srv;

namespace {

/// Messages that are published one after the other before other callbacks have their turn.
constexpr int kRun = 50;
/// Progress is told so often; of a mission's duration, in whole steps.
constexpr Duration kProgressPeriod = std::chrono::seconds(1);

}  // namespace

/// The parameters, and what they said when the component was configured.
class BagPlayer::Settings {
 public:
  explicit Settings(BagPlayer& player) : player_(player) {
    auto& parameters = player.parameters();
    const auto seconds = [](std::string description) {
      return ParameterDescriptor{.description = std::move(description),
                                 .floating_point_range = FloatingPointRange{0.0, 1e9}};
    };
    bag_ = parameters.declare<std::string>(
        "bag", "", {.description = "folder of the bag, or a .db3, .mcap or .bag file"});
    rate_ = parameters.declare<double>("rate", 1.0,
                                       {.description = "seconds of the bag per second",
                                        .floating_point_range = FloatingPointRange{1e-6, 1e6}});
    loop_ = parameters.declare<bool>("loop", false,
                                     {.description = "begin again after the last message"});
    start_offset_ = parameters.declare<double>(
        "start_offset", 0.0, seconds("s of the bag that are left out at its beginning"));
    delay_ = parameters.declare<double>("delay", 0.0, seconds("s before the first message"));
    wait_ = parameters.declare<double>(
        "wait", 0.0,
        seconds("s for which no node or subscription may have appeared before the first message, "
                "and all subscriptions are matched; 0: it does not wait"));
    clock_frequency_ = parameters.declare<double>(
        "clock_frequency", 0.0,
        {.description = "Hz at which the bag's time is published on /clock; 0: not at all",
         .floating_point_range = FloatingPointRange{0.0, 1e4}});
    topics_ = parameters.declare<std::vector<std::string>>(
        "topics", {}, {.description = "topics of the bag that are played; none: all"});
    read_ahead_ = parameters.declare<std::int64_t>("read_ahead_queue_size", 1000,
                                                   {.description = "messages that are read ahead",
                                                    .integer_range = IntegerRange{1, 1'000'000}});
    qos_overrides_ = parameters.declare<std::string>(
        "qos_overrides", "",
        {.description = "file with QoS profiles by topic, in place of the recorded ones"});
    start_paused_ = parameters.declare<bool>("start_paused", false,
                                             {.description = "wait for the service resume"});
    use_sim_time_ = parameters.handle<bool>("use_sim_time");
  }

  /// Throws std::invalid_argument, QosProfileError.
  void read() {
    if (bag_.get().empty()) {
      throw std::invalid_argument("bag: no bag is named");
    }
    if (clock_frequency_.get() > 0.0 && use_sim_time_.get()) {
      throw std::invalid_argument(
          "use_sim_time: a player that publishes /clock cannot follow it, too");
    }
    qos_overrides.clear();
    if (const auto path = qos_overrides_.get(); !path.empty()) {
      for (const auto& [topic, qos] : read_qos_overrides(path)) {
        qos_overrides[expand_topic_name(topic, player_.node_name())] = qos;
      }
    }
    topics.clear();
    for (const auto& topic : topics_.get()) {
      topics.insert(expand_topic_name(topic, player_.node_name()));
    }
  }

  [[nodiscard]] std::filesystem::path bag() const { return bag_.get(); }
  [[nodiscard]] double rate() const { return rate_.get(); }
  [[nodiscard]] bool loop() const { return loop_.get(); }
  [[nodiscard]] Duration start_offset() const { return from_seconds(start_offset_.get()); }
  [[nodiscard]] Duration delay() const { return from_seconds(delay_.get()); }
  [[nodiscard]] Duration wait() const { return from_seconds(wait_.get()); }
  [[nodiscard]] double clock_frequency() const { return clock_frequency_.get(); }
  [[nodiscard]] std::size_t read_ahead() const {
    return static_cast<std::size_t>(read_ahead_.get());
  }
  [[nodiscard]] bool start_paused() const { return start_paused_.get(); }

  std::map<std::string, QoS> qos_overrides;
  std::set<std::string> topics;

 private:
  BagPlayer& player_;
  Parameter<std::string> bag_;
  Parameter<double> rate_;
  Parameter<bool> loop_;
  Parameter<double> start_offset_;
  Parameter<double> delay_;
  Parameter<double> wait_;
  Parameter<double> clock_frequency_;
  Parameter<std::vector<std::string>> topics_;
  Parameter<std::int64_t> read_ahead_;
  Parameter<std::string> qos_overrides_;
  Parameter<bool> start_paused_;
  Parameter<bool> use_sim_time_;
};

/// One bag that is played. Lives in the component's default group.
class BagPlayer::Playback {
 public:
  /// Makes the publishers. Throws bags::BagError, QosProfileError, std::invalid_argument.
  Playback(BagPlayer& player, const Settings& settings)
      : player_(player), settings_(settings), clock_(Time{}, settings.rate()) {
    auto reader = std::make_unique<bags::BagReader>(settings.bag());
    const auto& metadata = reader->metadata();
    begin_ = Time(Duration(metadata.starting_time));
    end_ = add_saturated(begin_, Duration(metadata.duration));
    start_ = add_saturated(begin_, settings.start_offset());
    if (start_ > end_) {
      throw std::invalid_argument(
          "start_offset = " + std::to_string(to_seconds(settings.start_offset())) +
          " s is behind the end of the bag, which has " +
          std::to_string(to_seconds(end_ - begin_)) + " s");
    }
    make_publishers(*reader);
    clock_.set(start_, steady_now());
    ahead_.emplace(std::move(reader), settings.read_ahead(), [this] { post_play(); });
    if (start_ > begin_) {
      ahead_->seek(start_);
    }
    graph_changes_ = player.context().graph().on_changed([this] {
      if (!is_checking_.exchange(true)) {
        post([this] {
          is_checking_ = false;
          refuse_other_types();
          look_for_subscriptions();
        });
      }
    });
    refuse_other_types();
    serve();
  }
  Playback(const Playback&) = delete;
  Playback& operator=(const Playback&) = delete;
  ~Playback() {
    halt();
    graph_changes_.reset();
    ahead_.reset();
  }

  void start() {
    if (settings_.clock_frequency() > 0.0) {
      clock_publisher_ = player_.create_publisher(topics::kClock);
      clock_timer_ = player_.create_timer(from_seconds(1.0 / settings_.clock_frequency()),
                                          [this] { publish_clock(); });
    }
    progress_timer_ = player_.create_timer(kProgressPeriod, [this] { report(); });
    if (settings_.wait() > Duration::zero() && !has_played_) {
      std::vector<std::shared_ptr<UntypedPublisher>> publishers;
      for (const auto& publisher : publishers_) {
        if (publisher) {
          publishers.push_back(publisher.untyped());
        }
      }
      wait_.emplace(player_, std::move(publishers), settings_.wait(), [this] { begin(); });
    } else {
      begin();
    }
  }

  /// Stays where it is, until `start`.
  void halt() {
    wait_.reset();
    clock_.pause(steady_now());
    player_.default_group()->cancel(wake_);
    clock_timer_.reset();
    progress_timer_.reset();
  }

 private:
  /// Called when the next message is due.
  class Wake final : public Waitable {
   public:
    explicit Wake(std::function<void()> function) : function_(std::move(function)) {}
    void execute() override { function_(); }

   private:
    const std::function<void()> function_;
  };
  /// Messages that are to be played at once, while paused.
  struct Burst {
    std::optional<std::uint64_t> left;  // none: to the end
    std::uint64_t played = 0;
    std::function<void(std::uint64_t)> answer;
  };

  /// Runs in the default group, unless the playback has gone by then. From any thread.
  void post(std::function<void()> function) const {
    player_.default_group()->post([alive = std::weak_ptr(alive_), function = std::move(function)] {
      if (!alive.expired()) {
        function();
      }
    });
  }
  void post_play() {
    post([this] { play(); });
  }

  void begin() {
    if (!settings_.start_paused()) {
      clock_.resume(add_saturated(steady_now(), settings_.delay()));
    }
    post_play();
  }

  void look_for_subscriptions() {
    if (wait_) {
      wait_->look();
    }
  }

  void make_publishers(bags::BagReader& reader) {
    std::vector<std::string> played;
    publishers_.resize(reader.topics().size());
    std::set<std::string> missing = settings_.topics;
    for (std::size_t i = 0; i < publishers_.size(); ++i) {
      const auto& topic = reader.topics()[i];
      missing.erase(topic.name);
      if (!settings_.topics.empty() && !settings_.topics.contains(topic.name)) {
        continue;
      }
      if (settings_.clock_frequency() > 0.0 && topic.name == topics::kClock.name) {
        continue;  // there is one time only
      }
      if (topic.serialization_format != "cdr") {
        refuse(topic.name, "its messages are '" + topic.serialization_format + "', not cdr");
        continue;
      }
      try {
        const auto override = settings_.qos_overrides.find(topic.name);
        const QoS qos = override != settings_.qos_overrides.end()
                            ? override->second
                            : offer_for(qos_profiles_from_yaml(topic.offered_qos_profiles));
        publishers_[i] = player_.create_generic_publisher(
            topic.name, topic.type, qos,
            {.events = {.matched = [this](std::size_t) { look_for_subscriptions(); }}});
        played.push_back(topic.name);
      } catch (const InvalidName& error) {
        refuse(topic.name, error.what());
      } catch (const TopicTypeMismatch& error) {
        refuse(topic.name, error.what());
      } catch (const QosProfileError& error) {
        refuse(topic.name, std::string("its QoS cannot be read: ") + error.what());
      }
    }
    for (const auto& name : missing) {
      player_.logger().warn("the bag has no topic '" + name + "'");
    }
    if (played.size() < publishers_.size()) {
      reader.set_filter({.topics = std::move(played)});
    }
  }

  void refuse(const std::string& topic, const std::string& why) const {
    player_.diagnostics().count("not_played." + topic);
    player_.logger().error("topic '" + topic + "' is not played: " + why);
  }

  /// Two types under one name are never matched by DDS; the topic would seem to be played.
  void refuse_other_types() {
    std::map<std::string, std::string> others;  // type by topic
    const auto endpoints = player_.context().graph().endpoints();
    for (auto& publisher : publishers_) {
      if (!publisher) {
        continue;
      }
      const auto& topic = publisher.untyped()->topic();
      const auto other =
          std::find_if(endpoints.begin(), endpoints.end(), [&](const auto& endpoint) {
            return endpoint.wire_topic == topic.name && endpoint.wire_type != topic.type->dds_name;
          });
      if (other != endpoints.end()) {
        refuse(demangle_topic_name(topic.name)->name,
               "in the bag it is " + std::string(topic.type->name) + ", but " +
                   (other->node ? other->node->fully_qualified() : "somebody") +
                   " on the network uses it as " +
                   demangle_type_name(other->wire_type).value_or(other->wire_type));
        publisher = {};
      }
    }
  }

  /// Publishes what is due, or is asked for.
  void play() {
    if (!ahead_) {
      return;
    }
    for (int i = 0; i < kRun; ++i) {
      const BagItem* item = ahead_->next();
      if (item == nullptr) {
        if (ahead_->at_end()) {
          end();
        }
        return;
      }
      const SteadyTime now = steady_now();
      if (!bursts_.empty()) {
        clock_.set(item->stamp, now);
        publish(*item);
        advance_burst();
        continue;
      }
      if (clock_.paused()) {
        return;
      }
      if (clock_.time(now) < item->stamp) {
        player_.default_group()->schedule_at(clock_.when(item->stamp, now), wake_);
        return;
      }
      publish(*item);
    }
    post_play();
  }

  void publish(const BagItem& item) {
    if (auto& publisher = publishers_.at(item.topic)) {
      publisher.publish(item.message);
    }
    position_ = item.stamp;
    has_played_ = true;
    ahead_->pop();
  }

  void advance_burst() {
    Burst& burst = bursts_.front();
    ++burst.played;
    if (burst.left && burst.played == *burst.left) {
      burst.answer(burst.played);
      bursts_.pop_front();
    }
  }

  void end() {
    for (const Burst& burst : std::exchange(bursts_, {})) {
      burst.answer(burst.played);
    }
    if (const std::string error = ahead_->error(); !error.empty()) {
      if (!std::exchange(is_complete_, true)) {
        player_.report_failed("the bag could not be read to its end: " + error);
      }
      return;
    }
    if (clock_.paused()) {
      return;
    }
    if (settings_.loop() && std::exchange(has_played_, false)) {
      clock_.set(start_, steady_now());
      ahead_->seek(start_);
      post_play();
      return;
    }
    if (!std::exchange(is_complete_, true)) {
      player_.report_complete("the bag has been played");
    }
  }

  void report() const {
    const auto done = std::clamp(position_, start_, end_) - start_;
    const auto seconds = [](Duration duration) {
      return static_cast<std::uint64_t>(std::chrono::ceil<std::chrono::seconds>(duration).count());
    };
    if (!ahead_->at_end()) {
      player_.report_progress(seconds(done), std::max<std::uint64_t>(seconds(end_ - start_), 1));
    }
  }

  void publish_clock() {
    rosgraph_msgs::msg::Clock clock;
    clock.clock = to_message(clock_.time(steady_now()));
    clock_publisher_.publish(clock);
  }

  void pause() { clock_.pause(steady_now()); }
  void resume() {
    wait_.reset();
    clock_.resume(steady_now());
    play();
  }

  template <class S, class Handler>
  void serve(const char* name, Handler handler) {
    services_.push_back(player_.create_service<S>(name, std::move(handler)).untyped());
  }

  void serve() {
    serve<srv::Pause>("~/pause",
                      [this](const srv::Pause::Request&, srv::Pause::Response&) { pause(); });
    serve<srv::Resume>("~/resume",
                       [this](const srv::Resume::Request&, srv::Resume::Response&) { resume(); });
    serve<srv::TogglePaused>(
        "~/toggle_paused", [this](const srv::TogglePaused::Request&, srv::TogglePaused::Response&) {
          clock_.paused() ? resume() : pause();
        });
    serve<srv::IsPaused>("~/is_paused",
                         [this](const srv::IsPaused::Request&, srv::IsPaused::Response& response) {
                           response.paused = clock_.paused();
                         });
    serve<srv::GetRate>("~/get_rate",
                        [this](const srv::GetRate::Request&, srv::GetRate::Response& response) {
                          response.rate = clock_.rate();
                        });
    serve<srv::SetRate>("~/set_rate", [this](const srv::SetRate::Request& request,
                                             srv::SetRate::Response& response) {
      response.success = std::isfinite(request.rate) && request.rate > 0.0;
      if (response.success) {
        clock_.set_rate(request.rate, steady_now());
        play();
      }
    });
    serve<srv::Seek>("~/seek",
                     [this](const srv::Seek::Request& request, srv::Seek::Response& response) {
                       const Time time = from_message(request.time);
                       response.success = time >= begin_ && time <= end_;
                       if (response.success) {
                         clock_.set(time, steady_now());
                         ahead_->seek(time);
                         is_complete_ = false;
                         play();
                       }
                     });
    serve<srv::PlayNext>("~/play_next", [this](const std::shared_ptr<const srv::PlayNext::Request>&,
                                               const Responder<srv::PlayNext>& responder) {
      burst(1, [responder](std::uint64_t played) {
        srv::PlayNext::Response response;
        response.success = played == 1;
        responder.respond(response);
      });
    });
    serve<srv::Burst>("~/burst", [this](const std::shared_ptr<const srv::Burst::Request>& request,
                                        const Responder<srv::Burst>& responder) {
      const auto wanted = request->num_messages;
      burst(wanted == 0 ? std::nullopt : std::optional(wanted), [responder](std::uint64_t played) {
        srv::Burst::Response response;
        response.actually_burst = played;
        responder.respond(response);
      });
    });
  }

  void burst(std::optional<std::uint64_t> messages, std::function<void(std::uint64_t)> answer) {
    if (!clock_.paused()) {
      answer(0);
      return;
    }
    bursts_.push_back({messages, 0, std::move(answer)});
    play();
  }

  BagPlayer& player_;
  const Settings& settings_;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  const std::shared_ptr<Wake> wake_ = std::make_shared<Wake>([this] { play(); });
  std::atomic<bool> is_checking_{false};
  PlaybackClock clock_;
  Time begin_{};                              // of the bag
  Time end_{};                                // of the bag
  Time start_{};                              // where it is begun
  Time position_{};                           // of the message played last
  bool has_played_ = false;                   // something, since the beginning
  bool is_complete_ = false;                  // and was said to be
  std::vector<GenericPublisher> publishers_;  // by the bag's index; empty: not played
  Publisher<rosgraph_msgs::msg::Clock> clock_publisher_;
  std::deque<Burst> bursts_;
  std::optional<ReadAhead> ahead_;
  std::optional<SubscriptionWait> wait_;
  std::vector<std::shared_ptr<UntypedService>> services_;
  std::shared_ptr<Timer> clock_timer_;
  std::shared_ptr<Timer> progress_timer_;
  std::shared_ptr<void> graph_changes_;
};

BagPlayer::BagPlayer(ComponentOptions options)
    : Component(std::move(options)), settings_(std::make_unique<Settings>(*this)) {}

BagPlayer::~BagPlayer() = default;

CallbackReturn BagPlayer::on_configure() {
  try {
    settings_->read();
    playback_ = std::make_unique<Playback>(*this, *settings_);
  } catch (const std::exception& error) {
    diagnostics().set_status(DiagnosticLevel::kError, error.what());
    return CallbackReturn::kFailure;
  }
  return CallbackReturn::kSuccess;
}

CallbackReturn BagPlayer::on_activate() {
  playback_->start();
  return CallbackReturn::kSuccess;
}

CallbackReturn BagPlayer::on_deactivate() {
  playback_->halt();
  return CallbackReturn::kSuccess;
}

CallbackReturn BagPlayer::on_cleanup() {
  playback_.reset();
  return CallbackReturn::kSuccess;
}

CallbackReturn BagPlayer::on_shutdown() {
  playback_.reset();
  return CallbackReturn::kSuccess;
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::BagPlayer)
