// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "pipescout/runtime/time.hpp"

/// What the process tells the service manager (systemd) that started it, over the socket that
/// NOTIFY_SOCKET names. Without that variable nothing happens; a manager that does not listen is no
/// error. Of several processes of one run only the first one calls these.
namespace pipescout::host::service_manager {

/// The service is up; `status`: one line for people.
void tell_ready(const std::string& status);
void tell_stopping();
/// The process works. To be told more often than every `watchdog_period`.
void tell_alive();

/// Within which the manager wants to hear `tell_alive` (WatchdogSec=), else it ends the service.
[[nodiscard]] std::optional<Duration> watchdog_period();

}  // namespace pipescout::host::service_manager
