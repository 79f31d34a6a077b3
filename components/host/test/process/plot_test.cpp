// SPDX-License-Identifier: Apache-2.0
// `pipescout plot`, on small missions made here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"
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

/// A flight over a rack of two pipes, as its recorder writes it.
class RackDrawing : public Drawing {
 protected:
  void SetUp() override {
    Drawing::SetUp();
    fs::create_directories(path("f/rack/images"));
    std::string poses = pose_columns() +
                        ",x_standard_deviation,y_standard_deviation,z_standard_deviation,"
                        "rotation_x_standard_deviation,rotation_y_standard_deviation,"
                        "rotation_z_standard_deviation,x_y_correlation\n";
    std::string truth = pose_columns() + "\n";
    std::string states = "stamp,status\n";
    std::string offsets = "stamp,pipe,offset,standard_deviation,observed\n";
    std::string commands = "stamp,linear_x,linear_y,linear_z,angular_x,angular_y,angular_z\n";
    std::string images = "stamp,file\n";
    for (int k = 0; k < kPoses; ++k) {
      const std::string stamp = std::to_string(1000.0 + 0.04 * k);
      const std::string along = std::to_string(2.0 + 0.01 * k);
      // Straight down, the upper border of the image ahead.
      const std::string rest = ",1.5,1,0,0,0";
      poses += stamp + ",0.5," + along + rest + ",0.002,0.003,0.002,0.001,0.001,0.001,0.1\n";
      truth += stamp + ",0.501," + along + rest + "\n";
      states += stamp + ",tracking\n";
      offsets += stamp + ",A,0,0,0\n" + stamp + ",B,0.012,0.001,1\n";
      commands += stamp + ",0.25,0,0,0,0,0\n";
      if (k % 5 == 0) {
        const std::string image = "images/" + std::to_string(k) + ".pgm";
        images += stamp + "," + image + "\n";
        write("f/rack/" + image, "P5\n60 40\n255\n" + std::string(60UL * 40, 'p'));
      }
    }
    write("f/rack/pose.csv", poses);
    write("f/rack/truth.csv", truth);
    write("f/rack/state.csv", states);
    write("f/rack/offsets.csv", offsets);
    write("f/rack/command.csv", commands);
    write("f/rack/images.csv", images);
    write("f/rack/way_points.csv", "stamp,done,of,message\n1000.400000000,1,1,\"1 of 1\"\n");
    write("f/rack/rack.yaml",
          "row:\n  - {name: A, radius: 0.15, length: 10}\n"
          "  - {name: B, radius: 0.15, length: 10, gap: 0.1}\n");
    write("f/rack/camera.yaml",
          "image_width: 60\nimage_height: 40\n"
          "camera_matrix: {data: [50, 0, 30, 0, 50, 20, 0, 0, 1]}\n"
          "distortion_coefficients: {data: [0, 0, 0, 0, 0]}\n");
    write("f/mission.yaml",
          "components:\n  - {type: 'pipescout::VisualServo', name: visual_servo,\n"
          "     parameters: {way_points: [0.5, 2.2, 1.5, 1.57]}}\n");
  }

  static constexpr int kPoses = 25;

 private:
  static std::string pose_columns() { return "stamp,x,y,z,qx,qy,qz,qw"; }
};

TEST_F(RackDrawing, DrawsAllPicturesOfAFlight) {
  const auto finished = run({"rack", "f"});
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.err, IsEmpty());
  EXPECT_THAT(finished.out, Eq("f/pictures/flight.svg\nf/pictures/errors.svg\n"
                               "f/pictures/offsets.svg\nf/pictures/overlay.svg\n"
                               "f/pictures/map.svg\nf/pictures/animation.gif\n"));
  EXPECT_THAT(content(path("f/pictures/overlay.svg")),
              AllOf(StartsWith("<?xml"), HasSubstr("model at the estimated pose")));
  EXPECT_THAT(content(path("f/pictures/animation.gif")), StartsWith("GIF89a"));
}

TEST_F(RackDrawing, DrawsTheRestOfAFlightWithABrokenFileAndOneThatIsMissing) {
  write("f/rack/rack.yaml", "row:\n  - {name: A, radius: wide, length: 10}\n");
  fs::remove(path("f/rack/truth.csv"));
  const auto finished = run({"rack", "f"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.out, Eq("f/pictures/flight.svg\nf/pictures/offsets.svg\n"));
  EXPECT_THAT(finished.err, AllOf(HasSubstr("rack.yaml: line 2: 'radius' is no finite number"),
                                  HasSubstr("not drawn: errors: no truth.csv")));
}

TEST_F(RackDrawing, OnlyAMissingFileIsNoError) {
  fs::remove(path("f/rack/images.csv"));
  const auto finished = run({"rack", "f", "--format", "png", "--out", "p"});
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.out, Eq("p/flight.png\np/errors.png\np/offsets.png\np/map.png\n"));
  EXPECT_THAT(finished.err, HasSubstr("not drawn: overlay: no images.csv"));
}

TEST_F(Drawing, DrawsAStateEstimator) {
  fs::create_directories(path("e/estimator"));
  write("e/estimator/factors.csv",
        "stamp,kind,outcome,chi_square,degrees,weight\n"
        "1000.1,gps,accepted,2.5,3,1\n1000.2,gps,gated,300,3,0\n");
  const auto finished = run({"estimator", "e"});
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.out, Eq("e/pictures/residuals.svg\n"));
  EXPECT_THAT(finished.err, HasSubstr("not drawn: trajectory: no estimate.csv"));
  EXPECT_THAT(content(path("e/pictures/residuals.svg")), HasSubstr("gps: 1 accepted, 1 gated"));
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
