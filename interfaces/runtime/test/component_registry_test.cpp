// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/component_registry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "loadable_components/prefix.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// What a call that must throw `Error` says.
template <class Error, class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

/// Sets an environment variable for the time of a test.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) {
      before_ = before;
    }
    setenv(name, value.c_str(), 1);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  ~Environment() {
    if (before_) {
      setenv(name_, before_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }

 private:
  const char* const name_;
  std::optional<std::string> before_;
};

std::string index_line(const std::string& class_name) {
  return class_name + ";" + loadable_components().string() + "\n";
}

TEST(ComponentRegistry, ListsWhatThePackagesOffer) {
  const TemporaryPrefix prefix;
  prefix.add("pkg_b", "b::Two;lib/libb.so\nb::One;lib/libb.so\n");
  prefix.add("pkg_a", "a::Only;lib/liba.so\r\n\n");
  const ComponentRegistry registry({prefix.path()});
  const auto root = std::filesystem::canonical(prefix.path());
  EXPECT_EQ(registry.types(),
            (std::vector<ComponentType>{{"a::Only", "pkg_a", root / "lib/liba.so"},
                                        {"b::One", "pkg_b", root / "lib/libb.so"},
                                        {"b::Two", "pkg_b", root / "lib/libb.so"}}));
  EXPECT_THAT(registry.problems(), IsEmpty());
}

TEST(ComponentRegistry, KnowsWhoLooksAtTheWholeGraph) {
  const TemporaryPrefix prefix;
  prefix.add("pkg", "a::Recorder;lib/liba.so;sees_whole_graph\na::Driver;lib/liba.so\n");
  const ComponentRegistry registry({prefix.path()});
  EXPECT_TRUE(registry.sees_whole_graph("a::Recorder"));
  EXPECT_FALSE(registry.sees_whole_graph("a::Driver"));
  EXPECT_FALSE(registry.sees_whole_graph("a::Unknown"));
  EXPECT_THAT(registry.problems(), IsEmpty());
}

TEST(ComponentRegistry, AnOverlayHidesThePackageBelow) {
  const TemporaryPrefix overlay;
  const TemporaryPrefix underlay;
  overlay.add("pkg", "a::New;lib/libnew.so\n");
  underlay.add("pkg", "a::Old;lib/libold.so\n");
  const ComponentRegistry registry({overlay.path(), underlay.path()});
  ASSERT_EQ(registry.types().size(), 1U);
  EXPECT_EQ(registry.types().front().class_name, "a::New");
}

TEST(ComponentRegistry, NamesTheLinesThatItCannotRead) {
  const TemporaryPrefix prefix;
  prefix.add("pkg", "a::One;lib/liba.so\nnonsense\n;lib/x.so\na::Two;\na::One;lib/other.so\n");
  const ComponentRegistry registry({prefix.path()});
  EXPECT_EQ(registry.types().size(), 1U);
  ASSERT_EQ(registry.problems().size(), 4U);
  EXPECT_THAT(registry.problems()[0], HasSubstr("pkg:2: "));
  EXPECT_THAT(registry.problems()[0], HasSubstr("'nonsense'"));
  EXPECT_THAT(registry.problems()[3], HasSubstr("pkg:5: class 'a::One'"));
}

TEST(ComponentRegistry, MissingPrefixesAndFoldersInTheIndexAreNoTrouble) {
  const TemporaryPrefix prefix;
  std::filesystem::create_directories(prefix.index() / "folder");
  const ComponentRegistry registry({"/no/such/prefix", prefix.path(), prefix.path()});
  EXPECT_THAT(registry.types(), IsEmpty());
  ASSERT_EQ(registry.problems().size(), 1U);
  EXPECT_THAT(registry.problems().front(), HasSubstr("folder"));
  EXPECT_THAT(error_of<UnknownComponent>([&] { (void)registry.find("a::B"); }),
              HasSubstr("1 prefix searched"));
}

TEST(ComponentRegistry, TheEnvironmentGivesThePrefixes) {
  const TemporaryPrefix first;
  const TemporaryPrefix second;
  const Environment ament("AMENT_PREFIX_PATH", first.path().string() + "::/no/such/prefix");
  const Environment cmake("CMAKE_PREFIX_PATH",
                          second.path().string() + ":" + first.path().string());
  const auto prefixes = ComponentRegistry::default_prefixes();
  ASSERT_GE(prefixes.size(), 2U);
  EXPECT_EQ(prefixes[0], std::filesystem::canonical(first.path()));
  EXPECT_EQ(prefixes[1], std::filesystem::canonical(second.path()));
}

TEST(ComponentRegistry, AnUnknownClassNamesWhatIsNear) {
  const TemporaryPrefix prefix;
  prefix.add("pkg", "pipescout::OdometryFusion;lib/liba.so\npipescout::Replay;lib/libb.so\n");
  const ComponentRegistry registry({prefix.path()});
  const auto error = [&](const char* name, const char* package = "") {
    return error_of<UnknownComponent>([&] { (void)registry.find(name, package); });
  };
  EXPECT_THAT(error("pipescout::OdometryFusoin"), HasSubstr("'pipescout::OdometryFusoin'"));
  EXPECT_THAT(error("pipescout::OdometryFusoin"),
              HasSubstr("did you mean 'pipescout::OdometryFusion'?"));
  EXPECT_THAT(error("OdometryFusion"), HasSubstr("did you mean 'pipescout::OdometryFusion'?"));
  EXPECT_THAT(error("completely::Different"), HasSubstr("2 known, in 1 prefix"));
  EXPECT_THAT(error("pipescout::Replay", "other"), HasSubstr("another package provides it"));
}

TEST(ComponentRegistry, AClassOfTwoPackagesNeedsThePackage) {
  const TemporaryPrefix prefix;
  prefix.add("pkg_a", "a::Same;lib/liba.so\n");
  prefix.add("pkg_b", "a::Same;lib/libb.so\n");
  const ComponentRegistry registry({prefix.path()});
  const auto error = error_of<UnknownComponent>([&] { (void)registry.find("a::Same"); });
  EXPECT_THAT(error, HasSubstr("'pkg_a'"));
  EXPECT_THAT(error, HasSubstr("'pkg_b'"));
  EXPECT_EQ(registry.find("a::Same", "pkg_b").package, "pkg_b");
}

TEST(ComponentRegistry, MakesAComponentThatWorks) {
  const TemporaryPrefix prefix;
  prefix.add("pkg", index_line("loadable::Counter"));
  const ComponentRegistry registry({prefix.path()});
  testing::ComponentHarness harness;
  const auto component = registry.create(
      "loadable::Counter",
      harness.component_options({.name = "counter", .parameters = {{"gain", 2.0}}}));
  EXPECT_EQ(component->node_name().fully_qualified(), "/counter");
  EXPECT_EQ(component->parameters().get("gain"), ParameterValue(2.0));
  EXPECT_TRUE(harness.bring_up(*component).success);
}

TEST(ComponentRegistry, PassesOnWhatTheConstructorThrows) {
  const TemporaryPrefix prefix;
  prefix.add("pkg",
             index_line("loadable::ThrowsWhenConstructed") + index_line("loadable::Counter"));
  const ComponentRegistry registry({prefix.path()});
  testing::ComponentHarness harness;
  EXPECT_THAT(error_of<std::runtime_error>([&] {
                (void)registry.create("loadable::ThrowsWhenConstructed",
                                      harness.component_options({.name = "broken"}));
              }),
              HasSubstr("no serial number"));
  // The name is free again.
  EXPECT_NE(registry.create("loadable::Counter", harness.component_options({.name = "broken"})),
            nullptr);
}

TEST(ComponentRegistry, AMissingLibraryGivesTheReasonOfTheLoader) {
  const TemporaryPrefix prefix;
  prefix.add("pkg", "a::Gone;lib/libgone.so\n");
  const ComponentRegistry registry({prefix.path()});
  testing::ComponentHarness harness;
  const auto error = error_of<ComponentLoadError>(
      [&] { (void)registry.create("a::Gone", harness.component_options({})); });
  EXPECT_THAT(error, HasSubstr("lib/libgone.so"));
  EXPECT_THAT(error, HasSubstr("No such file or directory"));
}

TEST(ComponentRegistry, AFileThatIsNoLibraryGivesTheReasonOfTheLoader) {
  const TemporaryPrefix prefix;
  std::filesystem::create_directories(prefix.path() / "lib");
  std::ofstream(prefix.path() / "lib/libtext.so") << "this is no library, though it is long enough "
                                                     "for the header of one to fit in";
  prefix.add("pkg", "a::Text;lib/libtext.so\n");
  const ComponentRegistry registry({prefix.path()});
  testing::ComponentHarness harness;
  EXPECT_THAT(error_of<ComponentLoadError>(
                  [&] { (void)registry.create("a::Text", harness.component_options({})); }),
              HasSubstr("invalid ELF header"));
}

TEST(ComponentRegistry, ALibraryWithoutTheClassIsAnError) {
  const TemporaryPrefix prefix;
  prefix.add("pkg", index_line("loadable::NotThere"));
  const ComponentRegistry registry({prefix.path()});
  testing::ComponentHarness harness;
  EXPECT_THAT(error_of<ComponentLoadError>([&] {
                (void)registry.create("loadable::NotThere", harness.component_options({}));
              }),
              HasSubstr("registers no component class 'loadable::NotThere'"));
}

TEST(ComponentRegistry, ANodeIsNamedAfterItsClass) {
  EXPECT_EQ(default_component_name("pipescout::OdometryFusion"), "odometry_fusion");
  EXPECT_EQ(default_component_name("Replay"), "replay");
  EXPECT_EQ(default_component_name("a::IMUDriver"), "imu_driver");
  EXPECT_EQ(default_component_name("a::Camera2Driver"), "camera2_driver");
  EXPECT_EQ(default_component_name("a::already_snake"), "already_snake");
}

}  // namespace
}  // namespace pipescout
