// SPDX-License-Identifier: Apache-2.0
// Types of a ROS 2 workspace, of which only the definitions are installed, and types of other names
// than the network has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/runtime/executor_thread.hpp"
#include "pipescout/runtime/node.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ForeignTypes : public ::testing::Test {
 protected:
  Finished run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin() + 2, {"--spin-time", "30"});
    return run_program(arguments, folder_.path());
  }
  static const MessageType& type(const std::string& name) {
    return load_message_type("valve_msgs/" + name);
  }
  static FieldEditor field(const MessageType& type, const std::shared_ptr<void>& message,
                           std::string_view name) {
    return {*find_field(type, name), message.get()};
  }

  const bool has_prefix_ = setenv("AMENT_PREFIX_PATH", TEST_PREFIX, 1) == 0;
  ::pipescout::testing::TemporaryFolder folder_;
  std::shared_ptr<Context> context_ =
      Context::create(create_dds_transport(DdsOptions::from_environment()));
  Executor executor_;
  Node node_{{.context = context_,
              .executor = &executor_,
              .name = {"/", "keeper"},
              .standard_interfaces = false}};
  ExecutorThread thread_{executor_, {}};
};

TEST_F(ForeignTypes, AreEchoed) {
  const auto& valve = type("msg/Valve");
  const auto publisher = node_.create_untyped_publisher("valve", valve, QoS::latched(1));
  const auto message = valve.create();
  field(valve, message, "name").set(0, std::string_view("V12"));
  field(valve, message, "label").set(0, std::string_view("große"));
  auto pressures = field(valve, message, "pressures");
  pressures.resize(2);
  pressures.set(1, ScalarValue(2.5));
  publisher->publish(message, {});
  const auto echoed = run({"topic", "echo", "/valve", "--once"});
  EXPECT_EQ(echoed.code(), 0) << echoed.err;
  EXPECT_EQ(echoed.out,
            "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\n"
            "name: V12\n"
            "handles:\n- angle: 0.5\n  locks: []\n- angle: 0.5\n  locks: []\n"
            "pressures:\n- 0.0\n- 2.5\n"
            "label: große\n"
            "since:\n  sec: 0\n  nanosec: 0\n---\n");
}

TEST_F(ForeignTypes, ArePublished) {
  const auto& valve = type("msg/Valve");
  std::mutex mutex;
  std::shared_ptr<const void> received;
  const auto subscription = node_.create_untyped_subscription(
      "commanded", valve, QoS::reliable(1),
      [&](const std::shared_ptr<const void>& message, const MessageInfo&) {
        const std::lock_guard lock(mutex);
        received = message;
      });
  const auto published = run({"topic", "pub", "-1", "/commanded", "valve_msgs/msg/Valve",
                              "{name: V3, handles: [{locks: [true, false]}, {angle: 2.0}]}"});
  EXPECT_EQ(published.code(), 0) << published.err;
  eventually([&] {
    const std::lock_guard lock(mutex);
    return received != nullptr;
  });
  const std::lock_guard lock(mutex);
  ASSERT_NE(received, nullptr);
  const MessageView view{&valve, received.get()};
  EXPECT_EQ(find_field(view, "name").text(), "V3");
  const auto handles = find_field(view, "handles");
  EXPECT_EQ(find_field(handles.message(0), "locks").size(), 2U);
  EXPECT_EQ(find_field(handles.message(1), "angle").scalar(), ScalarValue(2.0));
  EXPECT_THAT(run({"topic", "pub", "-1", "/commanded", "valve_msgs/msg/Valve",
                   "{name: longer than twelve}"})
                  .err,
              HasSubstr("exceeds the bound of 12"));
}

TEST_F(ForeignTypes, AreCalled) {
  const auto& response_type = type("srv/Turn_Response");
  std::shared_ptr<UntypedService> service;
  service = create_untyped_service(
      *context_,
      {.name = "/turn",
       .request = &type("srv/Turn_Request"),
       .response = &response_type,
       .group = node_.default_group(),
       .enabled = false},
      [&](const std::shared_ptr<const void>& request, const SampleIdentity& caller) {
        const auto response = response_type.create();
        const auto& handle = *find_field(response_type, "handle");
        FieldEditor(*find_field(handle.message(), "angle"),
                    FieldEditor(handle, response.get()).message(0))
            .set(0, find_field({&type("srv/Turn_Request"), request.get()}, "angle").scalar());
        service->respond(caller, response);
      });
  service->set_enabled(true);
  const auto called = run({"service", "call", "/turn", "valve_msgs/srv/Turn", "{angle: 1.25}"});
  EXPECT_EQ(called.code(), 0) << called.err;
  EXPECT_THAT(called.out, HasSubstr("response:\nhandle:\n  angle: 1.25\n  locks: []\n"));
  const auto other = run({"service", "call", "/turn", "std_srvs/srv/Trigger"});
  EXPECT_EQ(other.code(), 1);
  EXPECT_EQ(other.err,
            "The service '/turn' is served as valve_msgs/srv/Turn, not as std_srvs/srv/Trigger\n");
}

TEST_F(ForeignTypes, AreGoals) {
  const auto types = load_action_types("valve_msgs/action/Close");
  UntypedActionHandlers handlers;
  handlers.decide = [](const GoalId&, const std::shared_ptr<const void>&) {
    return GoalDecision::kAccept;
  };
  handlers.accepted = [&](const UntypedActionHandlers::Goal& goal) {
    const auto turns = find_field(goal_in(types, goal->request().get()), "turns").scalar();
    const auto response = types.get_result_response->create();
    const auto& result = *find_field(*types.get_result_response, "result");
    FieldEditor(*find_field(result.message(), "report"),
                FieldEditor(result, response.get()).message(0))
        .set(0, std::to_string(std::get<std::int64_t>(turns)) + " turns");
    goal->end(GoalEvent::kSucceed, response);
  };
  const auto server = node_.create_untyped_action_server("close", types, std::move(handlers));
  const auto sent = run({"action", "send_goal", "/close", "valve_msgs/action/Close", "{turns: 7}"});
  EXPECT_EQ(sent.code(), 0) << sent.err;
  EXPECT_THAT(sent.out, AllOf(HasSubstr("Result:\n    report: 7 turns\n"),
                              HasSubstr("Goal finished with status: SUCCEEDED\n")));
}

TEST_F(ForeignTypes, AreShownAndListed) {
  const auto shown =
      run_program({"interface", "show", "valve_msgs/msg/Valve", "--no-comments"}, folder_.path());
  EXPECT_EQ(shown.code(), 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("string<=12 name \"none\"\nHandle[2] handles\n\tfloat64 angle "
                                   "0.5\n\tbool[<=3] locks\nfloat32[] pressures\nwstring label\n"));
  EXPECT_THAT(
      run_program({"interface", "list"}, folder_.path()).out,
      AllOf(HasSubstr("    valve_msgs/msg/Handle\n"), HasSubstr("    valve_msgs/srv/Turn\n"),
            HasSubstr("    valve_msgs/action/Close\n")));
  EXPECT_THAT(
      run_program({"interface", "proto", "valve_msgs/srv/Turn", "--no-quotes"}, folder_.path()).out,
      HasSubstr("angle: 0.0\n"));
}

/// Of which not even the definition is here.
TEST_F(ForeignTypes, NeedNoDefinitionForRateAndBandwidth) {
  auto publisher =
      node_.create_generic_publisher("measured", "nowhere_msgs/msg/Unknown", QoS::reliable(10));
  const auto timer = node_.create_timer(std::chrono::milliseconds(20), [&] {
    publisher.publish(std::make_shared<const SerializedMessage>(std::vector<std::byte>{
        std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}, std::byte{7}}));
  });
  for (const auto& [command, text] :
       {std::pair{"hz", "average rate: "}, {"bw", "Message size mean: "}}) {
    Program program({"topic", command, "/measured", "--spin-time", "30"}, folder_.path());
    EXPECT_TRUE(program.wait_for_out(text)) << program.err();
    program.signal(SIGINT);
    EXPECT_EQ(program.finish().code(), 0);
  }
  const auto echoed = run({"topic", "echo", "/measured"});
  EXPECT_EQ(echoed.code(), 1);
  EXPECT_THAT(echoed.err, HasSubstr("unknown type 'nowhere_msgs/msg/Unknown'"));
}

TEST_F(ForeignTypes, AnotherTypeThanThatOfTheTopicEndsTheCommand) {
  const auto publisher = node_.create_publisher<std_msgs::msg::String>("words", QoS::reliable(1));
  constexpr const char* kError =
      "Topic '/words' is used as std_msgs/msg/String, not as std_msgs/msg/Int32\n";
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"topic", "echo", "/words", "std_msgs/msg/Int32"},
        {"topic", "pub", "/words", "std_msgs/msg/Int32", "{data: 1}"},
        {"topic", "pub", "-1", "/words", "std_msgs/msg/Int32", "{data: 1}"}}) {
    const auto finished = run(command);
    EXPECT_EQ(finished.code(), 1) << command[1];
    EXPECT_EQ(finished.err, kError) << command[1];
  }
}

}  // namespace
}  // namespace pipescout::host
