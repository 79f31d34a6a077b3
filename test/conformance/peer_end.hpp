// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <std_msgs/msg/int64.hpp>
#include <string>
#include <thread>
#include <vector>

#include "pipescout/runtime/node.hpp"

namespace pipescout::conformance {

/// "depth reliable transient_local deadline_ms manual lease_ms", numbers; 0 ms: none.
[[nodiscard]] std::string to_text(const QoS& qos);

/// The other end of a conformance test: an endpoint on an executor thread of its own, driven by
/// lines of text, so that the same code serves in the test's process and in another one.
///
///   publisher TOPIC QOS...      -> ok        subscription TOPIC QOS...   -> ok
///   publish VALUE               -> ok        assert                      -> ok   (liveliness)
///   wait matched N              -> ok | timeout
///   wait received N             -> the values, separated by spaces | timeout
///   wait deadline_missed N      -> ok | timeout      also: liveliness_lost, incompatible
///   drop                        -> ok        destroys the endpoint
class PeerEnd {
 public:
  explicit PeerEnd(std::shared_ptr<Context> context);
  ~PeerEnd();
  PeerEnd(const PeerEnd&) = delete;
  PeerEnd& operator=(const PeerEnd&) = delete;

  /// Returns the answer; "error: ..." for a line that is not one of the above.
  std::string execute(const std::string& line);

 private:
  struct Counts {
    std::size_t matched = 0;
    std::uint64_t deadline_missed = 0;
    std::uint64_t liveliness_lost = 0;
    std::uint64_t incompatible = 0;
    std::vector<std::int64_t> received;
  };

  template <class Change>
  void change(Change change);
  template <class Condition>
  bool wait(Condition condition);
  std::string wait_for(const std::string& what, std::uint64_t count);

  Executor executor_;
  Node node_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Counts counts_;
  Publisher<std_msgs::msg::Int64> publisher_;
  Subscription<std_msgs::msg::Int64> subscription_;
  std::thread spinner_;
};

}  // namespace pipescout::conformance
