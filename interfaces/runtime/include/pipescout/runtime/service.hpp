// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "pipescout/runtime/context.hpp"

namespace pipescout {

/// The reason why a call got no response.
enum class ServiceError {
  kNoServer,    ///< no server was matched in both directions before the time-out
  kServerGone,  ///< the request was sent, but no server is left to answer it
  kTimeout,     ///< a server was matched but did not answer in time
  kCancelled,   ///< the client was destroyed
  kOverloaded,  ///< too many outstanding calls of this client; the request was not sent
};

[[nodiscard]] const char* to_string(ServiceError error) noexcept;

/// A response or an error.
template <class Response>
class ServiceResult {
  using Shared = std::shared_ptr<const Response>;

 public:
  explicit ServiceResult(Shared response, const Gid& server = {})
      : value_(std::move(response)), server_(server) {}
  explicit ServiceResult(ServiceError error) : value_(error) {}
  [[nodiscard]] explicit operator bool() const noexcept { return value_.index() == 0; }
  [[nodiscard]] const Response* operator->() const { return std::get<0>(value_).get(); }
  [[nodiscard]] const Shared& shared() const { return std::get<0>(value_); }
  [[nodiscard]] ServiceError error() const { return std::get<1>(value_); }
  /// The reply writer of the server that answered; zero when none did.
  [[nodiscard]] const Gid& server() const noexcept { return server_; }

 private:
  std::variant<Shared, ServiceError> value_;
  Gid server_;
};

struct ServiceStatistics {
  std::uint64_t requests = 0;           ///< passed to the handler
  std::uint64_t responses = 0;          ///< published
  std::uint64_t responses_dropped = 0;  ///< the caller's reply reader did not appear in time
};

struct ClientStatistics {
  std::uint64_t calls = 0;
  std::uint64_t answered = 0;
  std::uint64_t without_server = 0;  ///< ended with ServiceError::kNoServer
  std::uint64_t server_gone = 0;     ///< ended with ServiceError::kServerGone
  std::uint64_t timed_out = 0;
  std::uint64_t refused = 0;       ///< ended with ServiceError::kOverloaded
  std::uint64_t late_replies = 0;  ///< to a call that had ended already
};

/// A service of types known at run time. Requests arrive in its callback group, and each is
/// answered through `respond`, at once or later, from any thread. A response to a client in another
/// process whose reply reader is not matched yet waits for it, for one second at most.
class UntypedService {
 public:
  using Handler =
      std::function<void(const std::shared_ptr<const void>& request, const SampleIdentity& caller)>;
  virtual ~UntypedService() = default;
  /// Throws std::invalid_argument when the response is null.
  virtual void respond(const SampleIdentity& caller, std::shared_ptr<const void> response) = 0;
  /// While disabled, requests wait in the queue; responses still leave.
  virtual void set_enabled(bool enabled) = 0;
  [[nodiscard]] virtual ServiceStatistics statistics() const = 0;
  [[nodiscard]] virtual std::shared_ptr<UntypedPublisher> reply_publisher() const = 0;
  [[nodiscard]] virtual std::shared_ptr<UntypedSubscription> request_subscription() const = 0;
};

/// A client of types known at run time. At most `kMaxOutstandingCalls` calls wait for their answer,
/// and as many for the callback of their refusal.
class UntypedClient {
 public:
  static constexpr std::size_t kMaxOutstandingCalls = 1000;

  using Answer = std::function<void(ServiceResult<void>)>;
  /// Calls `answer` with kCancelled for every outstanding call, on the destroying thread.
  /// Exceptions from these calls are ignored.
  virtual ~UntypedClient() = default;
  /// Sends the request once a server is matched in both directions, so that its reply cannot be
  /// lost, and calls `answer` exactly once, in the client's callback group (but see the
  /// destructor). With several servers the first reply counts, and the call ends with kServerGone
  /// when all are gone. Throws std::invalid_argument when
  /// `request` or `answer` is null, std::runtime_error when the callbacks of `kMaxOutstandingCalls`
  /// refusals have not run yet. Returns the number of the call, 0 when it is refused. Thread-safe.
  virtual std::uint64_t call(std::shared_ptr<const void> request, Answer answer,
                             Duration timeout) = 0;
  /// Gives a call up: its answer is neither called nor waited for. False when the call has its
  /// answer already, or none is known by that number.
  virtual bool forget(std::uint64_t call) = 0;
  [[nodiscard]] virtual bool is_ready() const = 0;
  /// The server that `ServiceResult::server` named is there still.
  [[nodiscard]] virtual bool is_matched(const Gid& server) const = 0;
  [[nodiscard]] virtual ClientStatistics statistics() const = 0;
  [[nodiscard]] virtual std::shared_ptr<UntypedPublisher> request_publisher() const = 0;
  [[nodiscard]] virtual std::shared_ptr<UntypedSubscription> reply_subscription() const = 0;
};

struct ServiceOptions {
  std::string name;  ///< fully qualified ROS name: "/robot_1/odometry_fusion/get_parameters"
  const MessageType* request = nullptr;
  const MessageType* response = nullptr;
  QoS qos = QoS::services();
  std::shared_ptr<CallbackGroup> group;  ///< of the handler and the answers; not null
  /// Services only: start disabled, see UntypedService::set_enabled. Needed if the handler answers
  /// through the returned service, because a request may arrive before the function returns.
  bool enabled = true;
  /// Clients only: called in `group` after the servers that are matched changed. May be empty.
  std::function<void()> matched = {};
};

/// Throw what Context::create_publisher and create_subscription throw, InvalidName, and
/// std::invalid_argument when there is no group or no handler.
[[nodiscard]] std::shared_ptr<UntypedService> create_untyped_service(
    Context& context, const ServiceOptions& options, UntypedService::Handler handler);
[[nodiscard]] std::shared_ptr<UntypedClient> create_untyped_client(Context& context,
                                                                   const ServiceOptions& options);

/// Answers one request, once; may be stored and used later. If it is destroyed without an answer,
/// the caller times out.
template <class S>
class Responder {
 public:
  Responder(std::weak_ptr<UntypedService> service, const SampleIdentity& caller)
      : service_(std::move(service)), caller_(caller) {}
  void respond(typename S::Response response) const {
    if (const auto service = service_.lock()) {
      service->respond(caller_, std::make_shared<const typename S::Response>(std::move(response)));
    }
  }

 private:
  std::weak_ptr<UntypedService> service_;
  SampleIdentity caller_;
};

/// A handle: the service is destroyed with the last copy.
template <class S>
class Service {
 public:
  Service() = default;
  explicit Service(std::shared_ptr<UntypedService> untyped) : untyped_(std::move(untyped)) {}
  [[nodiscard]] const std::shared_ptr<UntypedService>& untyped() const { return untyped_; }

 private:
  std::shared_ptr<UntypedService> untyped_;
};

/// A handle: the client is destroyed with the last copy.
template <class S>
class Client {
 public:
  using Request = typename S::Request;
  using Response = typename S::Response;
  using Result = ServiceResult<Response>;

  Client() = default;
  explicit Client(std::shared_ptr<UntypedClient> untyped) : untyped_(std::move(untyped)) {}

  /// See UntypedClient::call. Never blocks.
  void call(Request request, std::function<void(Result)> answer,
            Duration timeout = std::chrono::seconds(5)) {
    untyped_->call(
        std::make_shared<const Request>(std::move(request)),
        [answer = std::move(answer)](ServiceResult<void> result) {
          if (result) {
            answer(
                Result(std::static_pointer_cast<const Response>(result.shared()), result.server()));
          } else {
            answer(Result(result.error()));
          }
        },
        timeout);
  }
  /// A server is matched in both directions.
  [[nodiscard]] bool is_ready() const { return untyped_->is_ready(); }
  [[nodiscard]] const std::shared_ptr<UntypedClient>& untyped() const { return untyped_; }
  [[nodiscard]] explicit operator bool() const noexcept { return untyped_ != nullptr; }

 private:
  std::shared_ptr<UntypedClient> untyped_;
};

}  // namespace pipescout
