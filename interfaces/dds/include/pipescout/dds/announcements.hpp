// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "pipescout/runtime/transport.hpp"

namespace pipescout {

/// A line of text that a process says of itself wherever its participant announces itself, and what
/// other processes say of themselves in the same way. It needs no topic: it is there as soon as the
/// participant is found, behind a discovery server and with DDS Security too (from participants
/// that have been authenticated), and is repeated with each announcement, so that a loss delays it
/// by an announcement at most. Others see it as a further key of the participant's user data,
/// "enclave=/;pipescout=TEXT;", which ROS 2 skips.
///
/// Shared by who says something and by the transport that it is given to (`DdsOptions`).
/// Thread-safe.
class Announcements {
 public:
  /// Announces the text from now on, at once; before there is a transport, with its first
  /// announcement. Throws std::invalid_argument when it contains ';' or '\0'; an empty text says
  /// nothing. Not from within `heard`.
  void say(const std::string& text);

  /// What the others say now, by their participants.
  [[nodiscard]] std::map<Gid, std::string> others() const;

  /// `heard` is called after each change of `others`, on threads of the transport that hold its
  /// locks: it may only note that there is news. An empty one ends that; no call is in progress
  /// then.
  void on_heard(std::function<void()> heard);

  /// For the transport: where the text goes. An empty function: nowhere, the transport ends.
  void connect(std::function<void(const std::string& text)> send);
  /// For the transport: the text that is said now.
  [[nodiscard]] std::string text() const;
  /// For the transport: what a participant says; an empty text: nothing any more, or it has gone.
  void hear(const Gid& participant, const std::string& text);

 private:
  std::mutex sending_mutex_;  // before mutex_: texts leave in the order in which they are said
  std::function<void(const std::string&)> send_;
  std::mutex hearing_mutex_;  // while `heard_` is called
  std::function<void()> heard_;
  mutable std::mutex mutex_;
  std::string text_;
  std::map<Gid, std::string> others_;
};

}  // namespace pipescout
