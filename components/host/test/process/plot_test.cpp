// SPDX-License-Identifier: Apache-2.0
// `pipescout plot`, on a small mission made here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "pipescout/interfaces/testing/temporary_folder.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

using ::pipescout::testing::content;
using ::testing::AllOf;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

constexpr const char* kPython = "/usr/bin/python3";
constexpr const char* kPythonVariable = "PIPESCOUT_PYTHON";

/// Debian's Python with Debian's matplotlib.
bool can_draw() {
  const std::string command = std::string(kPython) + " -c 'import matplotlib, yaml' 2>/dev/null";
  // NOLINTNEXTLINE(cert-env33-c): a fixed command
  return std::system(command.c_str()) == 0;
}

class PlotCommand : public ::testing::Test {
 protected:
  PlotCommand() {
    fs::create_directories(path("m/odometry"));
    write("m/odometry/readings.csv",
          "reading,stamp,a,b,a.standard_deviation,b.standard_deviation,a.valid,b.valid\n"
          "1,1.0,5.1,5.0,0.05,0.05,1,1\n2,1.1,5.2,5.1,0.05,0.05,1,1\n");
    write("m/odometry/fused.csv",
          "reading,stamp,distance,standard_deviation,status,fusion_set,a.rejection,b.rejection\n"
          "1,1.0,5.05,0.03,ok,1 2,none,none\n2,1.1,5.15,0.03,ok,1 2,none,none\n");
    ::unsetenv(kPythonVariable);
  }
  ~PlotCommand() override { ::unsetenv(kPythonVariable); }

  void SetUp() override {
    if (!fs::exists(fs::path(TEST_PREFIX) / "share/pipescout_plots/plot.py")) {
      GTEST_SKIP() << "NOTHING IS TESTED: no package pipescout_plots when this was configured";
    }
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] Finished run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "plot");
    return run_program(arguments, folder_.path());
  }

 private:
  ::pipescout::testing::TemporaryFolder folder_;
};

/// Those that need matplotlib.
class Drawing : public PlotCommand {
 protected:
  void SetUp() override {
    PlotCommand::SetUp();
    if (!IsSkipped() && !can_draw()) {
      GTEST_SKIP() << "NOTHING IS TESTED: " << kPython
                   << " has no matplotlib or no yaml; install the Debian packages "
                      "python3-matplotlib and python3-yaml";
    }
  }
};

TEST_F(Drawing, PrintsThePathOfEachPicture) {
  const auto finished = run({"odometry", "m"});
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.out, Eq("m/pictures/readings.svg\n"));
  EXPECT_THAT(finished.err, Not(HasSubstr("not drawn")));
  EXPECT_THAT(content(path("m/pictures/readings.svg")),
              AllOf(StartsWith("<?xml"), HasSubstr("in the fusion set")));
}

TEST_F(Drawing, WritesPngToAnotherFolder) {
  const auto finished = run({"odometry", "--out", "-p", "--format", "png", "m"});
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.out, Eq("-p/readings.png\n"));
  EXPECT_THAT(content(path("-p/readings.png")), StartsWith("\x89PNG"));
}

TEST_F(Drawing, NothingToDrawIsAnError) {
  const auto missing = run({"odometry", "gone"});
  EXPECT_EQ(missing.code(), 1);
  EXPECT_THAT(missing.err, HasSubstr("no mission folder or file 'gone'"));
  fs::create_directories(path("empty"));
  const auto empty = run({"odometry", "empty"});
  EXPECT_EQ(empty.code(), 1);
  EXPECT_THAT(empty.out, IsEmpty());
  EXPECT_THAT(empty.err, HasSubstr("nothing could be drawn"));
}

TEST_F(Drawing, NamesBadData) {
  write("m/odometry/readings.csv",
        "reading,stamp,a,a.standard_deviation,a.valid\n1,1.0,much,0.05,1\n");
  const auto finished = run({"odometry", "m"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("readings.csv: line 2: column 'a': 'much' is no number"));
}

TEST_F(PlotCommand, NamesThePackageOfAMissingPython) {
  ::setenv(kPythonVariable, path("no_python").c_str(), 1);
  const auto finished = run({"odometry", "m"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err,
              AllOf(HasSubstr("no_python: No such file"), HasSubstr("Debian package python3,")));
}

TEST_F(PlotCommand, NamesThePackageOfAMissingMatplotlib) {
  // Without the folders of installed packages.
  write("python", std::string("#!/bin/sh\nexec ") + kPython + " -S \"$@\"\n");
  fs::permissions(path("python"), fs::perms::owner_all);
  ::setenv(kPythonVariable, path("python").c_str(), 1);
  const auto finished = run({"odometry", "m"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("Debian package python3-matplotlib"));
}

TEST_F(PlotCommand, RefusesAWrongCommandLine) {
  EXPECT_EQ(run({}).code(), 2);
  EXPECT_EQ(run({"odometry"}).code(), 2);
  EXPECT_EQ(run({"odometry", "m", "--format", "jpg"}).code(), 2);
  const auto unknown = run({"odometri", "m"});
  EXPECT_EQ(unknown.code(), 2);
  EXPECT_THAT(unknown.err, HasSubstr("odometry"));
}

}  // namespace
}  // namespace pipescout::host
