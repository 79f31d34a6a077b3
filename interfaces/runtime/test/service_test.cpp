// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/service.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <memory>
#include <optional>
#include <std_srvs/srv/set_bool.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std_srvs::srv::SetBool;
using ::testing::ElementsAre;
using testing::FakeNetwork;
using ::testing::IsEmpty;

constexpr Duration kLong = seconds(30);
constexpr const char* kName = "/robot/switch";

ServiceOptions options(const std::shared_ptr<CallbackGroup>& group) {
  return {.name = kName,
          .request = &message_type<SetBool::Request>(),
          .response = &message_type<SetBool::Response>(),
          .group = group};
}

std::shared_ptr<const SetBool::Response> response(const std::string& text) {
  auto message = std::make_shared<SetBool::Response>();
  message->success = true;
  message->message = text;
  return message;
}

std::shared_ptr<const void> request(bool value = true) {
  auto message = std::make_shared<SetBool::Request>();
  message->data = value;
  return message;
}

/// A service that remembers its callers, and answers at once if it has a text.
struct Server {
  Server(Context& context, const std::shared_ptr<CallbackGroup>& group, std::string answer = "")
      : text(std::move(answer)) {
    ServiceOptions disabled = options(group);
    disabled.enabled = false;
    service = create_untyped_service(
        context, disabled,
        [this](const std::shared_ptr<const void>& asked, const SampleIdentity& caller) {
          callers.push_back(caller);
          values.push_back(static_cast<const SetBool::Request*>(asked.get())->data);
          if (!text.empty()) {
            service->respond(caller, response(text));
          }
        });
    service->set_enabled(true);
  }

  std::string text;
  std::vector<SampleIdentity> callers;
  std::vector<bool> values;
  std::shared_ptr<UntypedService> service;
};

/// A client, and what its calls were answered.
struct Caller {
  Caller(Context& context, const std::shared_ptr<CallbackGroup>& group)
      : client(create_untyped_client(context, options(group))) {}

  void call(Duration timeout = kLong) {
    client->call(
        request(),
        [this](const ServiceResult<void>& result) {
          answers.push_back(
              result ? static_cast<const SetBool::Response*>(result.shared().get())->message
                     : std::string(to_string(result.error())));
        },
        timeout);
  }

  std::vector<std::string> answers;
  std::shared_ptr<UntypedClient> client;
};

class ServiceInProcess : public ::testing::Test {
 protected:
  bool spin_until_answered(const Caller& caller, std::size_t answers) {
    return executor_.spin_until([&] { return caller.answers.size() >= answers; }, kLong);
  }

  Executor executor_;
  std::shared_ptr<CallbackGroup> group_ = executor_.create_callback_group();
  std::shared_ptr<Context> context_ = Context::create_in_process();
};

TEST_F(ServiceInProcess, AnswersACall) {
  Server server(*context_, group_, "done");
  Caller caller(*context_, group_);
  EXPECT_TRUE(caller.client->is_ready());
  caller.call();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, ElementsAre("done"));
  EXPECT_THAT(server.values, ElementsAre(true));
  EXPECT_EQ(server.callers.at(0).writer, caller.client->reply_subscription()->gid());
  EXPECT_EQ(server.service->reply_publisher()->topic().name, "rr/robot/switchReply");
  EXPECT_EQ(server.service->request_subscription()->topic().name, "rq/robot/switchRequest");
  EXPECT_EQ(caller.client->request_publisher()->topic().name, "rq/robot/switchRequest");
  EXPECT_EQ(server.service->statistics().requests, 1U);
  EXPECT_EQ(server.service->statistics().responses, 1U);
  EXPECT_EQ(caller.client->statistics().answered, 1U);
}

TEST_F(ServiceInProcess, TheTypedFrontCarriesRequestAndResponse) {
  std::weak_ptr<UntypedService> weak;
  ServiceOptions disabled = options(group_);
  disabled.enabled = false;
  const Service<SetBool> service(create_untyped_service(
      *context_, disabled,
      [&](const std::shared_ptr<const void>& asked, const SampleIdentity& who) {
        SetBool::Response reply;
        reply.success = static_cast<const SetBool::Request*>(asked.get())->data;
        reply.message = "typed";
        Responder<SetBool>(weak, who).respond(std::move(reply));
      }));
  weak = service.untyped();
  service.untyped()->set_enabled(true);
  Client<SetBool> client(create_untyped_client(*context_, options(group_)));
  SetBool::Request asked;
  asked.data = true;
  bool answered = false;
  client.call(std::move(asked), [&](const Client<SetBool>::Result& result) {
    ASSERT_TRUE(result);
    EXPECT_TRUE(result->success);
    EXPECT_EQ(result->message, "typed");
    answered = true;
  });
  executor_.spin_ready();
  EXPECT_TRUE(answered);
  // A responder whose service is gone does nothing.
  Responder<SetBool>({}, {}).respond({});
}

TEST_F(ServiceInProcess, EachClientGetsItsOwnAnswers) {
  const Server server(*context_, group_, "done");
  Caller first(*context_, group_);
  Caller second(*context_, group_);
  first.call();
  second.call();
  second.call();
  executor_.spin_ready();
  EXPECT_THAT(first.answers, ElementsAre("done"));
  EXPECT_THAT(second.answers, ElementsAre("done", "done"));
}

TEST_F(ServiceInProcess, AnswersMayComeLaterAndInAnyOrder) {
  const Server server(*context_, group_);
  Caller caller(*context_, group_);
  caller.call();
  caller.call();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, IsEmpty());
  ASSERT_EQ(server.callers.size(), 2U);
  std::thread other([&] {
    server.service->respond(server.callers[1], response("second"));
    server.service->respond(server.callers[0], response("first"));
  });
  other.join();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, ElementsAre("second", "first"));
}

TEST_F(ServiceInProcess, ACallWaitsForItsServer) {
  Caller caller(*context_, group_);
  EXPECT_FALSE(caller.client->is_ready());
  caller.call();
  caller.call();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, IsEmpty());
  const Server server(*context_, group_, "done");
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, ElementsAre("done", "done"));
}

TEST_F(ServiceInProcess, ACallWithoutServerEndsWithNoServer) {
  Caller caller(*context_, group_);
  caller.call(milliseconds(1));
  caller.call(Duration::zero());
  caller.call(-seconds(1));
  EXPECT_TRUE(spin_until_answered(caller, 3));
  EXPECT_THAT(caller.answers, ElementsAre("no server", "no server", "no server"));
  EXPECT_EQ(caller.client->statistics().without_server, 3U);
  // What timed out is not sent when a server comes.
  const Server server(*context_, group_, "done");
  executor_.spin_ready();
  EXPECT_THAT(server.callers, IsEmpty());
}

TEST_F(ServiceInProcess, ASilentServerEndsInATimeoutAndALateReplyIsCounted) {
  const Server server(*context_, group_);
  Caller caller(*context_, group_);
  caller.call(milliseconds(1));
  caller.call(Duration::max());
  EXPECT_TRUE(spin_until_answered(caller, 1));
  EXPECT_THAT(caller.answers, ElementsAre("timeout"));
  executor_.spin_ready();
  server.service->respond(server.callers.at(0), response("late"));
  server.service->respond(server.callers.at(1), response("in time"));
  server.service->respond(server.callers.at(1), response("again"));
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, ElementsAre("timeout", "in time"));
  EXPECT_EQ(caller.client->statistics().timed_out, 1U);
  EXPECT_EQ(caller.client->statistics().late_replies, 2U);
}

TEST_F(ServiceInProcess, CallsEndWithTheLastServerThatCouldAnswer) {
  std::optional<Server> first(std::in_place, *context_, group_);
  std::optional<Server> second(std::in_place, *context_, group_);
  Caller caller(*context_, group_);
  caller.call();
  caller.call(Duration::max());
  executor_.spin_ready();
  first.reset();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, IsEmpty());
  second->service->respond(second->callers.at(0), response("last word"));
  second.reset();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, ElementsAre("last word", "the server is gone"));
  EXPECT_EQ(caller.client->statistics().server_gone, 1U);
  // What comes later waits for the next server.
  caller.call();
  const Server next(*context_, group_, "next");
  executor_.spin_ready();
  EXPECT_EQ(caller.answers.back(), "next");
}

TEST_F(ServiceInProcess, DestroyingTheClientCancelsWhatIsOpenExactlyOnce) {
  const Server server(*context_, group_);
  std::optional<Caller> caller(std::in_place, *context_, group_);
  caller->call();
  executor_.spin_ready();
  caller->call();
  caller->client->call(
      request(), [](const ServiceResult<void>&) { throw std::runtime_error("ignored"); }, kLong);
  caller->call();
  caller->client.reset();
  EXPECT_THAT(caller->answers, ElementsAre("cancelled", "cancelled", "cancelled"));
  server.service->respond(server.callers.at(0), response("too late"));
  executor_.spin_ready();
  EXPECT_EQ(caller->answers.size(), 3U);
}

TEST_F(ServiceInProcess, AnAnswerMayDestroyTheClient) {
  const Server server(*context_, group_, "done");
  std::shared_ptr<UntypedClient> client = create_untyped_client(*context_, options(group_));
  std::vector<std::optional<ServiceError>> results;
  for (int i = 0; i < 2; ++i) {
    client->call(
        request(),
        [&](const ServiceResult<void>& result) {
          results.push_back(result ? std::nullopt : std::optional(result.error()));
          client.reset();
        },
        kLong);
  }
  executor_.spin_ready();
  EXPECT_THAT(results, ElementsAre(std::nullopt, ServiceError::kCancelled));
}

TEST_F(ServiceInProcess, TooManyOpenCallsAreRefused) {
  Caller caller(*context_, group_);
  for (std::size_t i = 0; i < UntypedClient::kMaxOutstandingCalls + 1; ++i) {
    caller.call();
  }
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, ElementsAre("too many calls outstanding"));
  EXPECT_EQ(caller.client->statistics().refused, 1U);
}

TEST_F(ServiceInProcess, RefusalsDoNotPileUpWithoutBound) {
  Caller caller(*context_, group_);
  constexpr std::size_t kMost = UntypedClient::kMaxOutstandingCalls;
  for (std::size_t i = 0; i < 2 * kMost; ++i) {
    caller.call();
  }
  EXPECT_THROW(caller.call(), std::runtime_error);
  // One of them at a time is in the queue of the executor.
  group_->post([&caller] { EXPECT_EQ(caller.answers.size(), 1U); });
  executor_.spin_ready();
  EXPECT_EQ(caller.answers, std::vector<std::string>(kMost, "too many calls outstanding"));
  caller.call();
  executor_.spin_ready();
  EXPECT_EQ(caller.answers.size(), kMost + 1);
  EXPECT_EQ(caller.client->statistics().refused, kMost + 2);
}

TEST_F(ServiceInProcess, DestroyingTheClientCancelsRefusalsThatNobodyWasToldOf) {
  Caller caller(*context_, group_);
  constexpr std::size_t kMost = UntypedClient::kMaxOutstandingCalls;
  for (std::size_t i = 0; i < kMost + 3; ++i) {
    caller.call();
  }
  caller.client.reset();
  EXPECT_EQ(caller.answers, std::vector<std::string>(kMost + 3, "cancelled"));
  EXPECT_EQ(executor_.spin_ready(), 1U);
  EXPECT_EQ(caller.answers.size(), kMost + 3);
}

TEST_F(ServiceInProcess, ADisabledServiceAnswersOnceEnabled) {
  const Server server(*context_, group_, "done");
  server.service->set_enabled(false);
  Caller caller(*context_, group_);
  caller.call();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, IsEmpty());
  server.service->set_enabled(true);
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, ElementsAre("done"));
}

TEST_F(ServiceInProcess, AnswersRunInTheGroupOfTheClient) {
  const auto other = executor_.create_callback_group();
  const Server server(*context_, group_, "done");
  Caller caller(*context_, other);
  caller.call();
  other->close();
  executor_.spin_ready();
  EXPECT_THAT(caller.answers, IsEmpty());
  EXPECT_EQ(server.callers.size(), 1U);
}

TEST_F(ServiceInProcess, RefusesWhatMakesNoSense) {
  EXPECT_THROW(create_untyped_client(*context_, options(nullptr)), std::invalid_argument);
  EXPECT_THROW(create_untyped_service(*context_, options(group_), nullptr), std::invalid_argument);
  ServiceOptions bad_name = options(group_);
  bad_name.name = "relative";
  EXPECT_THROW(create_untyped_client(*context_, bad_name), std::invalid_argument);
  const auto client = create_untyped_client(*context_, options(group_));
  EXPECT_THROW(client->call(
                   nullptr, [](const auto&) {}, kLong),
               std::invalid_argument);
  EXPECT_THROW(client->call(request(), nullptr, kLong), std::invalid_argument);
  const Server server(*context_, group_);
  EXPECT_THROW(server.service->respond({}, nullptr), std::invalid_argument);
}

TEST(ServiceThreads, ManyCallersFromManyThreads) {
  constexpr int kThreads = 3;
  constexpr int kCalls = 200;
  Executor executor(4);
  const auto context = Context::create_in_process();
  const auto server_group = executor.create_callback_group();
  const auto client_group = executor.create_callback_group(CallbackGroupType::kReentrant);
  std::atomic<int> failures{0};
  std::latch done(kThreads * kCalls);
  std::thread spinner([&] { executor.spin(); });
  {
    ServiceOptions deep = options(server_group);
    deep.qos = QoS::services();
    deep.qos.depth = kThreads * kCalls;
    std::shared_ptr<UntypedService> service;
    deep.enabled = false;
    service = create_untyped_service(
        *context, deep, [&](const std::shared_ptr<const void>&, const SampleIdentity& who) {
          service->respond(who, response("done"));
        });
    service->set_enabled(true);
    deep.group = client_group;
    const auto client = create_untyped_client(*context, deep);
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < kCalls; ++i) {
          client->call(
              request(),
              [&](const ServiceResult<void>& result) {
                failures += result ? 0 : 1;
                done.count_down();
              },
              kLong);
        }
      });
    }
    for (auto& thread : threads) {
      thread.join();
    }
    done.wait();
    server_group->close();
    client_group->close();
  }
  executor.stop();
  spinner.join();
  EXPECT_EQ(failures, 0);
}

/// Client and server in two processes.
class ServiceAcrossProcesses : public ::testing::Test {
 protected:
  struct Process {
    explicit Process(std::unique_ptr<Transport> transport)
        : context(Context::create(std::move(transport))) {}
    Executor executor;
    std::shared_ptr<CallbackGroup> group = executor.create_callback_group();
    std::shared_ptr<Context> context;
  };

  void settle() {
    while (network_.deliver() + here_.executor.spin_ready() + there_.executor.spin_ready() > 0) {
    }
  }

  static constexpr const char* kRequests = "rq/robot/switchRequest";
  static constexpr const char* kReplies = "rr/robot/switchReply";
  FakeNetwork network_;
  Process here_{network_.create_transport("here")};
  Process there_{network_.create_transport("there")};
};

TEST_F(ServiceAcrossProcesses, AnswersACallAndCarriesTheIdentitiesOfRos2) {
  const Server server(*there_.context, there_.group, "done");
  Caller caller(*here_.context, here_.group);
  caller.call();
  EXPECT_FALSE(caller.client->is_ready());
  settle();
  EXPECT_TRUE(caller.client->is_ready());
  EXPECT_THAT(caller.answers, ElementsAre("done"));
  // The reply reader of the client, and the number of the request on the network.
  EXPECT_EQ(server.callers.at(0), (SampleIdentity{caller.client->reply_subscription()->gid(), 1}));
}

TEST_F(ServiceAcrossProcesses, ACallWaitsUntilBothDirectionsAreMatched) {
  for (const char* held : {kRequests, kReplies}) {
    network_.hold_matching(held);
    const Server server(*there_.context, there_.group, "done");
    Caller caller(*here_.context, here_.group);
    caller.call();
    settle();
    EXPECT_FALSE(caller.client->is_ready()) << held;
    EXPECT_THAT(server.callers, IsEmpty()) << held;
    network_.allow_matching(held);
    settle();
    EXPECT_THAT(caller.answers, ElementsAre("done")) << held;
  }
}

TEST_F(ServiceAcrossProcesses, ALocalAndARemoteServerTheFirstReplyCounts) {
  const Server local(*here_.context, here_.group, "local");
  const Server remote(*there_.context, there_.group, "remote");
  Caller caller(*here_.context, here_.group);
  settle();
  caller.call();
  settle();
  caller.call();
  settle();
  EXPECT_THAT(caller.answers, ElementsAre("local", "local"));
  EXPECT_EQ(remote.callers.size(), 2U);
  EXPECT_EQ(caller.client->statistics().answered, 2U);
  EXPECT_EQ(caller.client->statistics().late_replies, 2U);
}

TEST_F(ServiceAcrossProcesses, LocalAndRemoteNumbersDoNotMix) {
  // The first call goes to the local server only, so the second is number 2 here and 1 there.
  const Server local(*here_.context, here_.group);
  Caller caller(*here_.context, here_.group);
  caller.call();
  settle();
  const Server remote(*there_.context, there_.group, "remote");
  settle();
  caller.call();
  settle();
  EXPECT_EQ(remote.callers.at(0).sequence_number, 1);
  EXPECT_EQ(local.callers.at(1).sequence_number, 2);
  EXPECT_THAT(caller.answers, ElementsAre("remote"));
  local.service->respond(local.callers.at(0), response("local"));
  settle();
  EXPECT_THAT(caller.answers, ElementsAre("remote", "local"));
}

/// A client that only speaks DDS, so that a test decides what it sends.
struct ForeignClient {
  ForeignClient(Context& context, const std::shared_ptr<CallbackGroup>& group)
      : requests(context.create_publisher(
            {.topic = {"rq/robot/switchRequest", &message_type<SetBool::Request>()}})),
        replies(context.create_subscription(
            {.topic = {"rr/robot/switchReply", &message_type<SetBool::Response>()},
             .callback = [this](const std::shared_ptr<const void>&,
                                const MessageInfo& info) { related.push_back(info.related); },
             .group = group})) {}

  std::vector<SampleIdentity> related;
  std::shared_ptr<UntypedPublisher> requests;
  std::shared_ptr<UntypedSubscription> replies;
};

TEST_F(ServiceAcrossProcesses, AClientThatDoesNotNameItsReaderIsAnsweredByItsWriter) {
  const Server server(*there_.context, there_.group, "done");
  const ForeignClient client(*here_.context, here_.group);
  settle();
  const auto sample = client.requests->publish(request(), {});
  settle();
  EXPECT_THAT(client.related,
              ElementsAre(SampleIdentity{client.requests->gid(), sample.remote_sequence_number}));
}

TEST_F(ServiceAcrossProcesses, ARemoteServerMayAnswerByTheWriterOfTheRequest) {
  Caller caller(*here_.context, here_.group);
  // A server that relates its reply to the request itself.
  std::shared_ptr<UntypedPublisher> replies =
      there_.context->create_publisher({.topic = {kReplies, &message_type<SetBool::Response>()}});
  const auto requests = there_.context->create_subscription(
      {.topic = {kRequests, &message_type<SetBool::Request>()},
       .callback =
           [&](const std::shared_ptr<const void>&, const MessageInfo& info) {
             replies->publish(response("by writer"), info.identity);
           },
       .group = there_.group});
  caller.call();
  settle();
  EXPECT_THAT(caller.answers, ElementsAre("by writer"));
}

TEST_F(ServiceAcrossProcesses, AResponseWaitsForTheReaderOfTheClient) {
  network_.hold_matching(kReplies);
  const Server server(*there_.context, there_.group, "done");
  const ForeignClient client(*here_.context, here_.group);
  settle();
  client.requests->publish(request(), {.writer = client.replies->gid(), .sequence_number = 0});
  settle();
  ASSERT_EQ(server.callers.size(), 1U);
  EXPECT_EQ(server.service->statistics().responses, 0U);
  network_.allow_matching(kReplies);
  settle();
  EXPECT_THAT(client.related, ElementsAre(SampleIdentity{client.replies->gid(), 1}));
  EXPECT_EQ(server.service->statistics().responses, 1U);
}

TEST_F(ServiceAcrossProcesses, AResponseLeavesAsSoonAsTheReaderIsMatchedEvenIfNobodyWasToldYet) {
  network_.hold_matching(kReplies);
  const Server server(*there_.context, there_.group);
  const ForeignClient client(*here_.context, here_.group);
  settle();
  client.requests->publish(request(), {.writer = client.replies->gid(), .sequence_number = 0});
  settle();
  ASSERT_EQ(server.callers.size(), 1U);
  network_.allow_matching(kReplies);
  const auto replies = server.service->reply_publisher();
  while (!replies->is_matched_remotely(client.replies->gid())) {
    ASSERT_TRUE(network_.deliver_one());
  }
  EXPECT_EQ(replies->remote_subscription_count(), 0);
  server.service->respond(server.callers[0], response("early"));
  settle();
  EXPECT_THAT(client.related, ElementsAre(SampleIdentity{client.replies->gid(), 1}));
}

TEST_F(ServiceAcrossProcesses, ACallThatMissesALeavingServerWaitsForTheNext) {
  std::optional<Server> leaving(std::in_place, *there_.context, there_.group, "never");
  Caller caller(*here_.context, here_.group);
  settle();
  const Gid left = leaving->service->request_subscription()->gid();
  leaving.reset();
  const auto requests = caller.client->request_publisher();
  while (requests->is_matched_remotely(left)) {
    ASSERT_TRUE(network_.deliver_one());
  }
  // The client will be told of it later.
  EXPECT_TRUE(caller.client->is_ready());
  caller.call();
  settle();
  EXPECT_THAT(caller.answers, IsEmpty());
  const Server next(*there_.context, there_.group, "next");
  settle();
  EXPECT_THAT(caller.answers, ElementsAre("next"));
}

TEST_F(ServiceAcrossProcesses, AResponseNobodyComesForIsDropped) {
  const Server server(*there_.context, there_.group);
  Gid nobody = here_.context->transport()->participant();
  nobody.bytes.back() = 0x04;
  server.service->respond({.writer = nobody, .sequence_number = 1}, response("lost"));
  EXPECT_TRUE(there_.executor.spin_until(
      [&] { return server.service->statistics().responses_dropped == 1; }, kLong));
  EXPECT_EQ(server.service->statistics().responses, 0U);
}

TEST_F(ServiceAcrossProcesses, AClientKnowsWhichServerAnsweredAndWhetherItIsThere) {
  for (const bool is_remote : {false, true}) {
    std::optional<Server> server;
    server.emplace(is_remote ? *there_.context : *here_.context,
                   is_remote ? there_.group : here_.group, "done");
    int changes = 0;
    ServiceOptions watching = options(here_.group);
    watching.matched = [&] { ++changes; };
    const auto client = create_untyped_client(*here_.context, watching);
    Gid answered;
    client->call(
        request(), [&](const ServiceResult<void>& result) { answered = result.server(); }, kLong);
    settle();
    EXPECT_EQ(answered, server->service->reply_publisher()->gid()) << is_remote;
    EXPECT_TRUE(client->is_matched(answered));
    EXPECT_FALSE(client->is_matched(Gid{}));
    EXPECT_GT(changes, 0);
    const int before = changes;
    server.reset();
    settle();
    EXPECT_GT(changes, before);
    EXPECT_FALSE(client->is_matched(answered)) << is_remote;
  }
}

TEST_F(ServiceAcrossProcesses, ACallThatIsForgottenIsNotAnswered) {
  const Server server(*there_.context, there_.group);
  Caller caller(*here_.context, here_.group);
  const auto answer = [&](const ServiceResult<void>&) { caller.answers.emplace_back("answered"); };
  const auto unsent = caller.client->call(request(), answer, kLong);
  EXPECT_TRUE(caller.client->forget(unsent));
  EXPECT_FALSE(caller.client->forget(unsent));
  settle();
  EXPECT_THAT(server.callers, IsEmpty());
  const auto sent = caller.client->call(request(), answer, milliseconds(1));
  settle();
  ASSERT_EQ(server.callers.size(), 1U);
  EXPECT_TRUE(caller.client->forget(sent));
  server.service->respond(server.callers[0], response("late"));
  settle();
  EXPECT_THAT(caller.answers, IsEmpty());
  EXPECT_EQ(caller.client->statistics().late_replies, 1U);
  EXPECT_FALSE(caller.client->forget(0));
}

TEST_F(ServiceAcrossProcesses, ACallEndsWhenItsServerIsGone) {
  std::optional<Server> server(std::in_place, *there_.context, there_.group);
  Caller caller(*here_.context, here_.group);
  settle();
  caller.call();
  settle();
  ASSERT_EQ(server->callers.size(), 1U);
  server.reset();
  settle();
  EXPECT_THAT(caller.answers, ElementsAre("the server is gone"));
}

TEST_F(ServiceAcrossProcesses, AServerThatCrashesLeavesACallToItsTimeout) {
  const Server server(*there_.context, there_.group, "done");
  Caller caller(*here_.context, here_.group);
  settle();
  network_.crash(there_.context->transport()->participant());
  caller.call(milliseconds(1));
  EXPECT_TRUE(here_.executor.spin_until([&] { return caller.answers.size() == 1; }, kLong));
  EXPECT_THAT(caller.answers, ElementsAre("timeout"));
  network_.deliver();
  EXPECT_FALSE(caller.client->is_ready());
}

}  // namespace
}  // namespace pipescout
