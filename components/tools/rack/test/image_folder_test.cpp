// SPDX-License-Identifier: Apache-2.0
#include "image_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::rack {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(NaturalOrder, TakesNumbersAsNumbers) {
  std::vector<std::string> names{"img_10", "img_2", "b1", "img_1", "img_02", "img_2a", "img"};
  std::ranges::sort(names, natural_less);
  EXPECT_THAT(names, ElementsAre("b1", "img", "img_1", "img_02", "img_2", "img_2a", "img_10"));
  EXPECT_FALSE(natural_less("a", "a"));
}

TEST(TimeInName, IsSecondsMillisecondsMicrosecondsOrNanoseconds) {
  EXPECT_EQ(time_in_name("1305031102.175304"), Stamp(nanoseconds(1'305'031'102'175'304'000)));
  EXPECT_EQ(time_in_name("left_1403636579763"), Stamp(milliseconds(1'403'636'579'763)));
  EXPECT_EQ(time_in_name("1403636579763555"), Stamp(nanoseconds(1'403'636'579'763'555'000)));
  EXPECT_EQ(time_in_name("1403636579763555584"), Stamp(nanoseconds(1'403'636'579'763'555'584)));
  for (const char* other : {"", "img", "img_12", "12.5", "20260301093000", "9999999999999",
                            "9999999999999999999", "99999999999999999999"}) {
    EXPECT_FALSE(time_in_name(other)) << other;
  }
}

class AFolder : public ::testing::Test {
 protected:
  void add(const std::string& name) {
    cv::imwrite((folder_.path() / name).string(), cv::Mat(3, 4, CV_8UC1, cv::Scalar(9)));
  }
  void add_text(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name) << text;
  }
  std::vector<std::string> names(ImageSource& source) {
    std::vector<std::string> result;
    while (const auto image = source.next()) {
      EXPECT_EQ(image->view.width, 4);
      EXPECT_EQ(image->view.height, 3);
      result.push_back(image->name);
      stamps_.push_back(image->stamp.time_since_epoch().count());
    }
    return result;
  }
  testing::TemporaryFolder folder_;
  std::vector<std::int64_t> stamps_;
};

TEST_F(AFolder, WithoutTimesIsInNaturalOrder) {
  for (const char* name : {"img_10.png", "img_2.PNG", "img_1.pgm"}) {
    add(name);
  }
  add_text("notes.txt", "no image");
  const auto source = open_folder(folder_.path(), {});
  EXPECT_EQ(source->count(), 3U);
  EXPECT_THAT(names(*source), ElementsAre("img_1.pgm", "img_2.PNG", "img_10.png"));
  EXPECT_THAT(stamps_, ElementsAre(0, 33'333'333, 66'666'667));
  EXPECT_THAT(source->said(),
              ElementsAre(HasSubstr("3 images; 1 other"), HasSubstr("no times: 30 per second")));
  const auto slow = open_folder(folder_.path(), {.rate = 2, .table = {}});
  stamps_.clear();
  EXPECT_EQ(names(*slow).size(), 3U);
  EXPECT_THAT(stamps_, ElementsAre(0, 500'000'000, 1'000'000'000));
}

TEST_F(AFolder, TakesTimesFromNamesOrTheTable) {
  add("b_1700000000100.png");
  add("a_1700000000200.png");
  EXPECT_THAT(names(*open_folder(folder_.path(), {})),
              ElementsAre("b_1700000000100.png", "a_1700000000200.png"));
  add("later.png");
  add("never.png");
  add_text("times.csv",
           "stamp,image\n12.5,b_1700000000100.png\n11.5,a_1700000000200.png\n13,later.png\n");
  const auto source = open_folder(folder_.path(), {});
  EXPECT_THAT(names(*source),
              ElementsAre("a_1700000000200.png", "b_1700000000100.png", "later.png"));
  ASSERT_EQ(source->left_out().size(), 1U);
  EXPECT_EQ(source->left_out()[0].name, "never.png");
  EXPECT_THAT(source->left_out()[0].reason, HasSubstr("no time"));
}

TEST_F(AFolder, TimesWithoutZeroPaddingAreAskedAbout) {
  add("1700000000.5000000.png");  // 5 ms or 0.5 s
  add("1700000000.25000000.png");
  EXPECT_THAT([&] { (void)open_folder(folder_.path(), {}); },
              ThrowsMessage<std::runtime_error>(
                  AllOf(HasSubstr("'1700000000.5000000.png' have different numbers of decimals"),
                        HasSubstr("--times or --rate"))));
  EXPECT_EQ(names(*open_folder(folder_.path(), {.rate = 2, .table = {}})).size(), 2U);
}

TEST_F(AFolder, FractionsWithoutZerosAtTheEndAreTimes) {
  add("1700000000.05.png");
  add("1700000000.1.png");
  EXPECT_THAT(names(*open_folder(folder_.path(), {})),
              ElementsAre("1700000000.05.png", "1700000000.1.png"));
  EXPECT_THAT(stamps_, ElementsAre(1'700'000'000'050'000'000, 1'700'000'000'100'000'000));
}

TEST_F(AFolder, DatesInNamesAreNotReadAndThisIsSaid) {
  add("cam_2024-1-5_3-7-2.png");
  EXPECT_THAT(open_folder(folder_.path(), {})->said(),
              ElementsAre(HasSubstr("1 image"), HasSubstr("Dates in names are not read")));
}

TEST_F(AFolder, TakesTheTableOfASpreadsheet) {
  add("a.png");
  add("b.png");
  add_text("times.csv", "image;stamp\r\na.png;1700000000250\r\nb.png;1700000000000\r\n");
  const auto source = open_folder(folder_.path(), {});
  EXPECT_THAT(names(*source), ElementsAre("b.png", "a.png"));
  EXPECT_THAT(stamps_, ElementsAre(1'700'000'000'000'000'000, 1'700'000'000'250'000'000));
  EXPECT_THAT(source->said(), ElementsAre(HasSubstr("2 images"), HasSubstr("in ms, by their size"),
                                          HasSubstr("times.csv")));
}

TEST_F(AFolder, NamesWhatIsWrong) {
  EXPECT_THAT([&] { (void)open_folder(folder_.path(), {}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("no image in it")));
  add("1.png");
  add_text("2.png", "cut off");
  const auto source = open_folder(folder_.path(), {});
  EXPECT_THAT(names(*source), ElementsAre("1.png"));
  ASSERT_EQ(source->left_out().size(), 1U);
  EXPECT_EQ(source->left_out()[0].name, "2.png");
  add_text("times.csv", "stamp,file\n1,1.png\n");
  EXPECT_THAT([&] { (void)open_folder(folder_.path(), {}); },
              ThrowsMessage<CsvError>(HasSubstr("column 'image' is missing")));
  add_text("times.csv", "stamp,image\nnoon,1.png\n");
  EXPECT_THAT([&] { (void)open_folder(folder_.path(), {}); },
              ThrowsMessage<CsvError>(HasSubstr("'noon' is not a time")));
}

}  // namespace
}  // namespace pipescout::rack
