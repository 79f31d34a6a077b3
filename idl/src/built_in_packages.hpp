// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "pipescout/idl/support/object_type.hpp"
#include "pipescout/idl/support/type_support.hpp"

namespace pipescout::idl {

/// Give the types of one package.
using ListTypes = PackageTypes (*)();
using ListObjects = PackageObjects (*)();

/// The functions of one package.
struct BuiltInPackage {
  ListTypes types;
  ListObjects objects;
};

/// The packages that this library holds; written by the build.
std::span<const BuiltInPackage> built_in_packages() noexcept;

}  // namespace pipescout::idl
