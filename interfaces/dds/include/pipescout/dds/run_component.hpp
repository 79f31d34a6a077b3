// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <typeinfo>

#include "pipescout/runtime/component.hpp"

/// One component as a program of its own.
namespace pipescout {

namespace detail {
int run_component(const ComponentFactory& factory, const std::type_info& type, int argc,
                  const char* const* argv);
}  // namespace detail

/// The body of a plain `main`:
///
///     int main(int argc, char** argv) { return pipescout::run<my::Camera>(argc, argv); }
///
/// Makes the component, in the root namespace and named after its class ("camera"), takes it to the
/// state active, and takes it down again when SIGINT, SIGTERM or SIGHUP asks for it, all within two
/// seconds. The command line is that of a ROS 2 node, `--ros-args ...`, see `parse_ros_arguments`;
/// a program with arguments of its own passes on those that are not its own.
///
/// Returns the exit code, after it has written what is wrong to the standard error stream:
///     0    it was stopped and has ended in good order, or was asked for `--help`
///     1    it could not start, or an exception left a callback of no component
///     2    an argument is wrong, or a parameter that it gives: unknown, out of range, of another
///     type
/// A program that does not end in time exits with 1, and at a second signal n with 128 + n.
///
/// A component that goes through its error state stays: it is reported on `/diagnostics`, and can
/// be configured again. Call this in the main thread before there are others, since it keeps the
/// signals from all threads that are made after it; it ignores SIGPIPE.
template <std::derived_from<Component> T>
[[nodiscard]] int run(int argc, const char* const* argv) {
  return detail::run_component(ComponentFactoryFor<T>(), typeid(T), argc, argv);
}

}  // namespace pipescout
