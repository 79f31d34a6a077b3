// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/component_container.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "loadable_components/prefix.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

namespace srv = composition_interfaces::srv;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ComponentContainerTest : public ::testing::Test {
 protected:
  ComponentContainerTest() {
    std::string index;
    for (const char* name : {"Counter", "ThrowsWhenConstructed", "ThrowsNoException",
                             "FailsToConfigure", "ThrowsInActivate", "Stubborn"}) {
      index += "loadable::" + std::string(name) + ";" + loadable_components().string() + "\n";
    }
    prefix_.add("loadable", index);
    container_.emplace(ContainerOptions{.context = harness_.context().shared_from_this(),
                                        .executor = &harness_.executor()},
                       ComponentRegistry({prefix_.path()}));
  }

  static srv::LoadNode::Request request(const std::string& class_name,
                                        const std::string& name = {}) {
    srv::LoadNode::Request result;
    result.package_name = "loadable";
    result.plugin_name = "loadable::" + class_name;
    result.node_name = name;
    return result;
  }

  srv::LoadNode::Response load(const srv::LoadNode::Request& wanted) {
    const auto result =
        harness_.call<srv::LoadNode>("/pipescout_container/_container/load_node", wanted);
    EXPECT_TRUE(result);
    return result ? *result.shared() : srv::LoadNode::Response();
  }

  /// The error of a load that must fail, and must leave nothing behind.
  std::string failed_load(const srv::LoadNode::Request& wanted) {
    const auto before = names();
    const auto response = load(wanted);
    EXPECT_FALSE(response.success);
    EXPECT_EQ(names(), before);
    return response.error_message;
  }

  srv::UnloadNode::Response unload(std::uint64_t id) {
    srv::UnloadNode::Request wanted;
    wanted.unique_id = id;
    const auto result =
        harness_.call<srv::UnloadNode>("/pipescout_container/_container/unload_node", wanted);
    EXPECT_TRUE(result);
    return result ? *result.shared() : srv::UnloadNode::Response();
  }

  std::vector<std::string> names() {
    const auto result =
        harness_.call<srv::ListNodes>("/pipescout_container/_container/list_nodes", {});
    EXPECT_TRUE(result);
    EXPECT_EQ(result->unique_ids.size(), result->full_node_names.size());
    return result ? result->full_node_names : std::vector<std::string>();
  }

  TransitionResult started(std::uint64_t id) {
    std::optional<TransitionResult> result;
    container_->start(id, [&result](const TransitionResult& outcome) { result = outcome; });
    EXPECT_TRUE(harness_.spin_until([&result] { return result.has_value(); }));
    return result.value_or(TransitionResult{});
  }

  TemporaryPrefix prefix_;
  testing::ComponentHarness harness_;
  std::optional<ComponentContainer> container_;
};

TEST_F(ComponentContainerTest, LoadsStartsListsAndUnloads) {
  const auto first = load(request("Counter"));
  ASSERT_TRUE(first.success) << first.error_message;
  EXPECT_EQ(first.full_node_name, "/counter");
  EXPECT_EQ(first.error_message, "");
  auto named = request("Counter", "other");
  named.node_namespace = "/robot_1";
  const auto second = load(named);
  ASSERT_TRUE(second.success) << second.error_message;
  EXPECT_EQ(second.full_node_name, "/robot_1/other");
  EXPECT_NE(first.unique_id, second.unique_id);
  EXPECT_THAT(names(), ElementsAre("/counter", "/robot_1/other"));
  for (const auto& loaded : container_->components()) {
    EXPECT_EQ(loaded.component->state(), LifecycleState::kActive);
    EXPECT_EQ(loaded.class_name, "loadable::Counter");
  }

  EXPECT_TRUE(unload(first.unique_id).success);
  EXPECT_THAT(names(), ElementsAre("/robot_1/other"));
  const auto again = load(request("Counter"));
  EXPECT_TRUE(again.success);
  EXPECT_NE(again.unique_id, first.unique_id);
}

TEST_F(ComponentContainerTest, AppliesParametersRemappingsAndLogLevel) {
  auto wanted = request("Counter");
  wanted.parameters = to_message(std::vector<NamedParameter>{{"gain", 3.0}});
  wanted.remap_rules = {"__node:=renamed"};
  wanted.log_level = 30;
  const auto response = load(wanted);
  ASSERT_TRUE(response.success) << response.error_message;
  EXPECT_EQ(response.full_node_name, "/renamed");
  const auto components = container_->components();
  ASSERT_EQ(components.size(), 1U);
  EXPECT_EQ(components.front().component->parameters().get("gain"), ParameterValue(3.0));
}

TEST_F(ComponentContainerTest, LeavesAComponentUnconfiguredOnRequest) {
  auto wanted = request("Counter");
  wanted.extra_arguments = to_message(
      std::vector<NamedParameter>{{"autostart", false}, {"use_intra_process_comms", true}});
  ASSERT_TRUE(load(wanted).success);
  EXPECT_EQ(container_->components().front().component->state(), LifecycleState::kUnconfigured);
}

TEST_F(ComponentContainerTest, RefusesWhatMakesNoSense) {
  EXPECT_THAT(failed_load(request("Cuonter")), HasSubstr("did you mean 'loadable::Counter'?"));

  auto wanted = request("Counter");
  wanted.package_name = "elsewhere";
  EXPECT_THAT(failed_load(wanted), HasSubstr("elsewhere"));

  EXPECT_THAT(failed_load(request("Counter", "not a name")), HasSubstr("not a name"));

  wanted = request("Counter");
  wanted.remap_rules = {"from-nothing"};
  EXPECT_THAT(failed_load(wanted), HasSubstr("from-nothing"));

  wanted = request("Counter");
  wanted.extra_arguments = to_message(std::vector<NamedParameter>{{"autostart", 1}});
  EXPECT_THAT(failed_load(wanted), HasSubstr("'autostart' is integer"));
}

TEST_F(ComponentContainerTest, WarnsOfWhatALoadRequestSaysInVain) {
  auto wanted = request("Counter");
  wanted.log_level = 25;
  wanted.extra_arguments = to_message(std::vector<NamedParameter>{{"autostrat", true}});
  wanted.parameters = to_message(std::vector<NamedParameter>{{"gian", 3.0}});
  const auto response = load(wanted);
  EXPECT_TRUE(response.success) << response.error_message;
  std::vector<std::string> warnings;
  for (const auto& entry : harness_.logs()) {
    if (entry.severity == LogSeverity::kWarn && entry.logger == "pipescout_container") {
      warnings.push_back(entry.text);
    }
  }
  EXPECT_THAT(warnings,
              ElementsAre("load_node: unknown extra argument 'autostrat'; ignored",
                          HasSubstr("log level 25"), HasSubstr("'gian'; did you mean 'gain'?")));
}

TEST_F(ComponentContainerTest, AProgramIsRefusedAParameterThatIsNotDeclared) {
  const auto misspelt = [this] {
    (void)container_->load({.class_name = "loadable::Counter",
                            .parameter_overrides = {{.name = "gian", .value = 3.0}}});
  };
  EXPECT_THROW(misspelt(), ParameterError);
  EXPECT_THAT(container_->components(), IsEmpty());
}

TEST_F(ComponentContainerTest, RefusesWrongParameters) {
  auto wanted = request("Counter");
  wanted.parameters = to_message(std::vector<NamedParameter>{{"gain", 30.0}});
  EXPECT_THAT(failed_load(wanted), HasSubstr("gain"));
  wanted.parameters = to_message(std::vector<NamedParameter>{{"gain", "much"}});
  EXPECT_THAT(failed_load(wanted), HasSubstr("gain"));
  wanted.parameters[0].value.type = 99;
  EXPECT_THAT(failed_load(wanted), HasSubstr("99"));
  EXPECT_TRUE(load(request("Counter")).success);
}

TEST_F(ComponentContainerTest, RefusesASecondComponentOfOneName) {
  ASSERT_TRUE(load(request("Counter")).success);
  EXPECT_THAT(failed_load(request("Counter")), HasSubstr("/counter"));
  EXPECT_EQ(container_->components().front().component->state(), LifecycleState::kActive);
}

TEST_F(ComponentContainerTest, AConstructorThatThrowsIsAnErrorOnly) {
  ASSERT_TRUE(load(request("Counter")).success);
  EXPECT_THAT(failed_load(request("ThrowsWhenConstructed")),
              HasSubstr("the sensor has no serial number"));
  EXPECT_THAT(failed_load(request("ThrowsNoException")), HasSubstr("not a std::exception"));
  EXPECT_THAT(names(), ElementsAre("/counter"));
}

TEST_F(ComponentContainerTest, AComponentThatDoesNotStartIsUnloadedAgain) {
  EXPECT_THAT(failed_load(request("FailsToConfigure")), HasSubstr("on_configure"));
  EXPECT_THAT(failed_load(request("ThrowsInActivate")), HasSubstr("no power"));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(ComponentContainerTest, AStubbornComponentIsUnloadedAllTheSame) {
  const auto response = load(request("Stubborn"));
  ASSERT_TRUE(response.success) << response.error_message;
  EXPECT_TRUE(unload(response.unique_id).success);
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(ComponentContainerTest, UnloadingWhatIsNotThereIsAnError) {
  const auto response = unload(77);
  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.error_message, HasSubstr("77"));
}

TEST_F(ComponentContainerTest, UnloadsOnce) {
  const auto loaded = container_->load({.class_name = "loadable::Counter"});
  std::vector<TransitionResult> results;
  const auto note = [&results](const TransitionResult& result) { results.push_back(result); };
  container_->unload(loaded.id, note);
  EXPECT_TRUE(container_->components().empty());
  container_->unload(loaded.id, note);
  container_->start(loaded.id, note);
  ASSERT_TRUE(harness_.spin_until([&results] { return results.size() == 3; }));
  int successes = 0;
  for (const auto& result : results) {
    successes += result.success ? 1 : 0;
    EXPECT_EQ(result.message.empty(), result.success);
  }
  EXPECT_EQ(successes, 1);
}

TEST_F(ComponentContainerTest, UnloadsWhileStarting) {
  const auto loaded = container_->load({.class_name = "loadable::Counter"});
  bool gone = false;
  container_->start(loaded.id);
  container_->unload(loaded.id, [&gone](const TransitionResult& result) { gone = result.success; });
  EXPECT_TRUE(harness_.spin_until([&gone] { return gone; }));
}

TEST_F(ComponentContainerTest, UnloadsAllInReverseOrder) {
  std::vector<std::weak_ptr<Component>> components;
  for (const char* name : {"a", "b", "c"}) {
    const auto loaded =
        container_->load({.class_name = "loadable::Counter", .name = {.ns = "/", .name = name}});
    ASSERT_TRUE(started(loaded.id).success);
    components.push_back(loaded.component);
  }
  // The last goes down while the first still works.
  std::vector<int> alive_at_each_end;
  bool done = false;
  container_->unload_all([&done] { done = true; });
  const auto alive = [&components] {
    int count = 0;
    for (const auto& component : components) {
      count += component.expired() ? 0 : 1;
    }
    return count;
  };
  ASSERT_TRUE(harness_.spin_until([&] {
    const int count = alive();
    if (alive_at_each_end.empty() || alive_at_each_end.back() != count) {
      alive_at_each_end.push_back(count);
      EXPECT_EQ(components[0].expired(), count == 0);
      EXPECT_EQ(components[2].expired(), count < 3);
    }
    return done;
  }));
  EXPECT_THAT(alive_at_each_end, ElementsAre(3, 2, 1, 0));
  bool again = false;
  container_->unload_all([&again] { again = true; });
  EXPECT_TRUE(harness_.spin_until([&again] { return again; }));
}

TEST_F(ComponentContainerTest, GoesWithComponentsStillActive) {
  ASSERT_TRUE(load(request("Counter")).success);
  container_.reset();
  harness_.spin();
  EXPECT_THAT(harness_.context().graph().nodes(), ElementsAre(harness_.peer().node_name()));
}

TEST_F(ComponentContainerTest, AComponentThatHangsDoesNotKeepTheOthersFromBeingUnloaded) {
  Executor executor(3);
  ComponentContainer container({.context = harness_.context().shared_from_this(),
                                .executor = &executor,
                                .name = {.ns = "/", .name = "threaded"}},
                               ComponentRegistry({prefix_.path()}));
  std::thread spinning([&executor] { executor.spin(); });
  const auto load_as = [&container](const char* name) {
    return container.load({.class_name = "loadable::Counter", .name = {.ns = "/", .name = name}});
  };
  const auto unload = [&container](std::uint64_t id) {
    const auto done = std::make_shared<std::promise<bool>>();
    container.unload(id,
                     [done](const TransitionResult& result) { done->set_value(result.success); });
    return done->get_future();
  };
  auto hanging = load_as("hanging");
  const auto sound = load_as("sound").id;
  std::promise<void> entered;
  std::promise<void> released;
  auto group = hanging.component->create_callback_group(CallbackGroupType::kReentrant);
  group->post([&] {
    entered.set_value();
    released.get_future().wait();
  });
  entered.get_future().wait();
  hanging.component.reset();
  auto hanging_unloaded = unload(hanging.id);
  EXPECT_TRUE(unload(sound).get());
  released.set_value();
  EXPECT_TRUE(hanging_unloaded.get());
  executor.stop();
  spinning.join();
}

TEST_F(ComponentContainerTest, ServesManyThreads) {
  Executor executor(3);
  ComponentContainer container({.context = harness_.context().shared_from_this(),
                                .executor = &executor,
                                .name = {.ns = "/", .name = "threaded"}},
                               ComponentRegistry({prefix_.path()}));
  std::atomic<int> ended{0};
  constexpr int kComponents = 12;
  for (int i = 0; i < kComponents; ++i) {
    const auto loaded =
        container.load({.class_name = "loadable::Counter",
                        .name = {.ns = "/threaded", .name = "counter_" + std::to_string(i)}});
    container.start(
        loaded.id, [&container, &ended, &executor, id = loaded.id](const TransitionResult& result) {
          EXPECT_TRUE(result.success) << result.message;
          container.unload(id, [&ended, &executor](const TransitionResult& unloaded) {
            EXPECT_TRUE(unloaded.success) << unloaded.message;
            if (++ended == kComponents) {
              executor.stop();
            }
          });
        });
  }
  executor.spin();
  EXPECT_EQ(ended, kComponents);
  EXPECT_TRUE(container.components().empty());
}

}  // namespace
}  // namespace pipescout
