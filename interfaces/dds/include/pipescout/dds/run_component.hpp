// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <typeinfo>

#include "pipescout/runtime/component.hpp"

/// One component as a stand-alone program.
namespace pipescout {

namespace detail {
int run_component(const ComponentFactory& factory, const std::type_info& type, int argc,
                  const char* const* argv);
}  // namespace detail

/// The body of a plain `main`:
///
///     int main(int argc, char** argv) { return pipescout::run<my::Camera>(argc, argv); }
///
/// Creates the component, in the root namespace and named after its class ("camera"), configures
/// and activates it, and shuts it down within two seconds on SIGINT, SIGTERM or SIGHUP. The command
/// line is that of a ROS 2 node, `--ros-args ...`, see `parse_ros_arguments`; a program with other
/// arguments passes only the remaining ones.
///
/// Returns the exit code, after writing errors to the standard error stream:
///     0    it was stopped and has ended in good order, or was asked for `--help`
///     1    it could not start, or an exception left a callback of no component
///     2    an argument is wrong, or a parameter that it gives: unknown, out of range, of another
///     type
/// A program that does not end in time exits with 1, and at a second signal n with 128 + n.
///
/// A component that goes through its error state is kept: it is reported on `/diagnostics`, and can
/// be configured again. Call this in the main thread before other threads exist, since it blocks
/// the signals in all threads created later; it ignores SIGPIPE.
template <std::derived_from<Component> T>
[[nodiscard]] int run(int argc, const char* const* argv) {
  return detail::run_component(ComponentFactoryFor<T>(), typeid(T), argc, argv);
}

}  // namespace pipescout
