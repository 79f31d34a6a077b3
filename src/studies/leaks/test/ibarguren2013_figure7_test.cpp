// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/ibarguren2013_figure7.hpp"

#include <gmock/gmock.h>

#include <iostream>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_reader.hpp"

namespace pipescout::leak_study {
namespace {

using thermal::PartKind;
using thermal::ProfileParameters;

std::vector<Figure7Part> figure7() {
  const std::string path = DATA_DIR "/ibarguren2013_figure7.csv";
  return read_figure7(read_csv_text(path), path);
}

/// Parts that leak lie together: where one begins that is labelled, and the one before is not.
int leak_stretches(const std::vector<Figure7Part>& parts, const Figure7Labels& labels,
                   const std::string& sequence) {
  int stretches = 0;
  bool before = false;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool leak = parts[i].sequence == sequence && labels.kinds[i] == PartKind::kLeak;
    stretches += leak && !before ? 1 : 0;
    before = leak;
  }
  return stretches;
}

TEST(Figure7, HasThirteenSequences) {
  const auto parts = figure7();
  EXPECT_EQ(parts.size(), 115U);
  EXPECT_EQ(parts.front().sequence, "PIA2");
  EXPECT_EQ(parts.back().sequence, "PIA35");
  EXPECT_DOUBLE_EQ(parts.back().mean, 128.23);
}

TEST(Figure7, AllSequencesAreFlaggedAndSoundPartsAreNot) {
  const auto parts = figure7();
  for (const auto& parameters : {ProfileParameters::torresol(), ProfileParameters{}}) {
    const Figure7Labels labels = label_figure7(parts, parameters);
    EXPECT_EQ(labels.sequences, 13U);
    EXPECT_EQ(labels.flagged, 13U);
    // The gap that the figure itself has between sound pipes and the edges of leaks.
    EXPECT_GT(labels.coldest_leak, 165.0);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      EXPECT_FALSE(parts[i].mean < 165 && labels.kinds[i] == PartKind::kLeak)
          << parts[i].sequence << ' ' << parts[i].part;
      EXPECT_FALSE(parts[i].mean > 190 && labels.kinds[i] != PartKind::kLeak)
          << parts[i].sequence << ' ' << parts[i].part;
    }
    // PIA4 shows two stretches of pipe, each with a leak.
    EXPECT_EQ(leak_stretches(parts, labels, "PIA4"), 2);
    for (const auto* sequence : {"PIA2", "PIA5", "PIA7", "PIA8", "PIA10", "PIA11", "PIA12", "PIA16",
                                 "PIA24", "PIA25", "PIA28", "PIA35"}) {
      EXPECT_EQ(leak_stretches(parts, labels, sequence), 1) << sequence;
    }
    std::cout << "cut-off " << labels.cut_off << " degC: sound to " << labels.warmest_sound
              << ", leaks from " << labels.coldest_leak << '\n';
  }
}

TEST(Figure7, NamesTheLineAndColumnThatIsWrong) {
  const std::string header = "sequence,stretch,part,mean_temperature\n";
  const auto error_of = [](const std::string& text) -> std::string {
    try {
      (void)read_figure7(text, "figure.csv");
    } catch (const CsvError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(error_of("heading\nPIA2\n"), testing::StartsWith("figure.csv:1: "));
  EXPECT_THAT(error_of(header + "PIA2,1,1\n"), testing::StartsWith("figure.csv:2: "));
  EXPECT_THAT(error_of(header + "PIA2,1,1,136\nPIA2,1,x,1\n"),
              testing::StartsWith("figure.csv:3: column 'part': 'x'"));
  EXPECT_THAT(error_of(header + "PIA2,1.5,1,136\n"), testing::HasSubstr("column 'stretch'"));
  EXPECT_THAT(error_of(header + "PIA2,1,0,136\n"), testing::HasSubstr("column 'part'"));
  EXPECT_THAT(error_of(header + "PIA2,1,1,nan\n"), testing::HasSubstr("column 'mean_temperature'"));
}

}  // namespace
}  // namespace pipescout::leak_study
