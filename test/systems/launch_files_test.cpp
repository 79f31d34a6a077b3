// SPDX-License-Identifier: Apache-2.0
// What the launch files say of parameters must be what the components declare.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "pipescout/runtime/component_registry.hpp"

namespace pipescout {
namespace {

std::vector<std::filesystem::path> launch_files() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(LAUNCH_SCRIPTS)) {
    if (entry.path().extension() == ".yaml" && YAML::LoadFile(entry.path())["components"]) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

class LaunchFileTest : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(LaunchFileTest, EveryParameterIsDeclaredAndDescribed) {
  const ComponentRegistry registry;
  const auto context = Context::create_in_process();
  Executor executor;
  std::size_t checked = 0;
  for (const YAML::Node& entry : YAML::LoadFile(GetParam())["components"]) {
    const auto type = entry["type"].as<std::string>();
    const auto component = registry.create(
        type,
        {.context = context, .executor = &executor, .name = {"/", default_component_name(type)}});
    for (const auto& parameter : entry["parameters"]) {
      const auto name = parameter.first.as<std::string>();
      ASSERT_TRUE(component->parameters().has(name)) << type << " declares no '" << name << "'";
      EXPECT_FALSE(component->parameters().describe({name}).front().description.empty())
          << type << " does not describe '" << name << "'";
      ++checked;
    }
  }
  EXPECT_GT(checked, 0U);
}

INSTANTIATE_TEST_SUITE_P(LaunchScripts, LaunchFileTest, testing::ValuesIn(launch_files()),
                         [](const testing::TestParamInfo<std::filesystem::path>& file) {
                           return file.param.stem().string();
                         });

}  // namespace
}  // namespace pipescout
