// SPDX-License-Identifier: Apache-2.0
// The order of images, sequences, and recordings that are not read.
#include "pipescout/thermal_files/picture_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/leak_survey/leak_survey.hpp"
#include "pipescout/thermal_files/testing/synthetic_flir.hpp"
#include "threshold_reader.hpp"

namespace pipescout {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::uint32_t kBegin = 1700000000;  // s since 1970

/// A warm pipe across an image of 80 x 60.
std::string frame(std::uint32_t taken) {
  test::SyntheticFlir flir;
  flir.width = 80;
  flir.height = 60;
  flir.counts.assign(80 * 60, 20118);
  std::fill_n(flir.counts.begin() + 80 * 28, 80 * 5, std::uint16_t{26000});
  flir.taken = taken;
  return flir.bytes();
}

class SurveyOrder : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(pictures_.path() / name, std::ios::binary) << bytes;
  }
  LeakSurveyResult survey() {
    LeakSurveyOptions options;
    options.read_parameters = test::read_threshold;
    options.pictures = pictures_.path();
    options.out = out_.path();
    options.complain = [this](const std::string& problem) { problems_.push_back(problem); };
    return survey_leaks(options);
  }
  std::vector<std::string> order(const std::map<std::string, double>& told = {}) const {
    const auto told_of = [&told](const std::string& name) {
      const auto found = told.find(name);
      return found == told.end() ? std::nullopt : std::optional(found->second);
    };
    std::vector<std::string> names;
    for (const FolderPicture& picture :
         pictures_in(pictures_.path(), told_of, ThermalFileReader({})).pictures) {
      names.push_back(picture.name());
    }
    return names;
  }

  ::pipescout::testing::TemporaryFolder pictures_;
  ::pipescout::testing::TemporaryFolder out_;
  std::vector<std::string> problems_;
};

TEST_F(SurveyOrder, NamesAreInTheOrderInWhichPeopleCount) {
  const std::vector<std::string> sorted{"",
                                        "9.png",
                                        "10.png",
                                        "IMG_1.jpg",
                                        "IMG_2.jpg",
                                        "IMG_02b.jpg",
                                        "IMG_10.jpg",
                                        "IMG_10a1.jpg",
                                        "IMG_10a02.jpg",
                                        "IMG_99999999999999999999999.jpg",
                                        "a"};
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    for (std::size_t j = 0; j < sorted.size(); ++j) {
      EXPECT_EQ(natural_less(sorted[i], sorted[j]), i < j) << sorted[i] << " " << sorted[j];
    }
  }
  EXPECT_NE(natural_less("1", "01"), natural_less("01", "1"));
}

TEST_F(SurveyOrder, TimesOfFilesComeBeforeNames) {
  write("IR_1.fff", frame(kBegin + 3));
  write("IR_2.fff", frame(kBegin + 1));
  write("IR_10.fff", frame(kBegin + 2));
  write("IR_11.fff", frame(5));  // a clock that was never set
  EXPECT_THAT(order(), ElementsAre("IR_2.fff", "IR_10.fff", "IR_1.fff", "IR_11.fff"));
  EXPECT_THAT(order({{"IR_11.fff", kBegin}}),
              ElementsAre("IR_11.fff", "IR_2.fff", "IR_10.fff", "IR_1.fff"));
}

TEST_F(SurveyOrder, SequencesAreSurveyedFrameByFrame) {
  write("b.seq", frame(kBegin) + frame(kBegin + 1) + frame(kBegin + 2));
  write("a.fff", frame(kBegin + 3));
  EXPECT_THAT(order(), ElementsAre("b.seq#1", "b.seq#2", "b.seq#3", "a.fff"));
  const LeakSurveyResult result = survey();
  EXPECT_EQ(result.pictures, 4U);
  EXPECT_EQ(result.failed, 0U);
  EXPECT_EQ(result.out_of_order, 0U);
  EXPECT_THAT(problems_, ElementsAre());
}

TEST_F(SurveyOrder, FramesOfSequencesTakeTheirTurns) {
  write("a.seq", frame(kBegin) + frame(kBegin + 2));
  write("b.seq", frame(kBegin + 1) + frame(5) + frame(kBegin + 4));
  write("c.fff", frame(kBegin + 3));
  EXPECT_THAT(order(), ElementsAre("a.seq#1", "b.seq#1", "b.seq#2", "a.seq#2", "c.fff", "b.seq#3"));
  EXPECT_EQ(survey().out_of_order, 0U);
}

TEST_F(SurveyOrder, PicturesOfOneSecondFollowEachOther) {
  for (const char* name : {"1.fff", "2.fff", "10.fff"}) {
    write(name, frame(kBegin));
  }
  write("11.fff", frame(kBegin + 1));
  const LeakSurveyResult result = survey();
  EXPECT_EQ(result.pictures, 4U);
  EXPECT_EQ(result.out_of_order, 0U);
  EXPECT_EQ(result.same_time, 2U);
  EXPECT_THAT(problems_, ElementsAre(HasSubstr("2 of 4 pictures have the time of the one before")));
}

TEST_F(SurveyOrder, WhatIsNotReadIsNamedAndCounted) {
  test::SyntheticFlir compressed;
  compressed.width = 80;  // more than there is: it is compressed
  compressed.counts[0] = 0xd8ff;
  compressed.counts[1] = 0xf7ff;
  const std::string bytes = compressed.bytes();
  write("a.csq", bytes + bytes + bytes);
  write("b.ats", "AGEMA");
  write("c.fff", frame(kBegin));
  write("notes.txt", "");
  const LeakSurveyResult result = survey();
  EXPECT_EQ(result.pictures, 1U);
  EXPECT_EQ(result.failed, 4U);
  EXPECT_EQ(problems_.size(), 3U);
  EXPECT_THAT(problems_, Contains(HasSubstr("a.csq: frame 1: its image is compressed as JPEG-LS")));
  EXPECT_THAT(problems_, Contains(HasSubstr("a.csq: 2 more frames likewise")));
  EXPECT_THAT(problems_, Contains(HasSubstr("b.ats: is a recording in a format")));
}

}  // namespace
}  // namespace pipescout
