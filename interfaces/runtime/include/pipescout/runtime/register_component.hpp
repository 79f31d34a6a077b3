// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <class_loader/class_loader.hpp>

#include "pipescout/runtime/component.hpp"

/// Makes a component class loadable by name. Once per class, in a source file of its library:
/// `PIPESCOUT_REGISTER_COMPONENT(pipescout::OdometryFusion)`.
#define PIPESCOUT_REGISTER_COMPONENT(Class) \
  CLASS_LOADER_REGISTER_CLASS(pipescout::ComponentFactoryFor<Class>, pipescout::ComponentFactory)
