// SPDX-License-Identifier: Apache-2.0
#include "image_folder.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_reader.hpp"

namespace pipescout::rack {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions{".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp", ".tif", ".tiff"};

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_image(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::find(kExtensions, extension) != kExtensions.end();
}

struct ImageFile {
  fs::path path;
  Stamp stamp{};
};

/// By the table; images that it does not name are left out.
void take_times(const fs::path& table, std::vector<ImageFile>& files,
                std::vector<LeftOut>& left_out, std::vector<std::string>& said) {
  const std::string text = read_csv_text(table.string());
  CsvReader reader(text, table.string());
  const auto image = reader.find_column("image");
  const auto stamp = reader.find_column("stamp");
  if (!image || !stamp) {
    throw CsvError(table.string(), reader.header_line(),
                   std::string("column '") + (image ? "stamp" : "image") + "' is missing");
  }
  said.insert(said.end(), reader.notes().begin(), reader.notes().end());
  if (const std::string note = reader.numbers()->time_note(*stamp); !note.empty()) {
    said.push_back(note);
  }
  std::unordered_map<std::string, Stamp> times;
  while (reader.next()) {
    const auto time = reader.time(*stamp);
    if (!time || *time < std::chrono::nanoseconds::zero()) {
      reader.refuse(*stamp, "a time in seconds or one such as 2026-11-29T07:36:05.25Z");
    }
    times[std::string(reader.cells()[*image])] = Stamp(*time);
  }
  std::vector<ImageFile> timed;
  for (ImageFile& file : files) {
    const auto time = times.find(file.path.filename().string());
    if (time == times.end()) {
      left_out.push_back({file.path.filename().string(), table.string() + " has no time of it"});
    } else {
      timed.push_back({std::move(file.path), time->second});
    }
  }
  files = std::move(timed);
}

/// Digits of a name behind its last point; empty: there are none.
std::string decimals_of(const ImageFile& file) {
  const std::string stem = file.path.stem().string();
  const std::size_t point = stem.rfind('.');
  const std::string decimals = point == std::string::npos ? "" : stem.substr(point + 1);
  return std::ranges::all_of(decimals, is_digit) ? decimals : "";
}

/// "1700000000.15000000" may be 0.15 s, or 15 ms as nanoseconds without the zeros in front. Of
/// names with different numbers of digits only such zeros show that they are fractions, whose zeros
/// at the end are missing.
void refuse_doubtful_decimals(const std::vector<ImageFile>& files) {
  bool differ = false;
  bool zero_in_front = false;
  bool zero_at_end = false;
  const std::string first = decimals_of(files.front());
  for (const ImageFile& file : files) {
    const std::string decimals = decimals_of(file);
    differ = differ || decimals.size() != first.size();
    zero_in_front = zero_in_front || (decimals.size() > 1 && decimals.front() == '0');
    zero_at_end = zero_at_end || (decimals.size() > 1 && decimals.back() == '0');
  }
  if (differ && (!zero_in_front || zero_at_end)) {
    throw std::runtime_error(
        "times in names such as '" + files.front().path.filename().string() +
        "' have different numbers of decimals: they may be fractions of a second, or nanoseconds "
        "without the zeros in front; give the times with --times or --rate");
  }
}

/// "2024-1-5_3-7-2": a date and a time, which names write in many orders.
bool holds_a_date(const std::string& name) {
  std::size_t groups = 0;
  for (std::size_t at = name.find("20"); at < name.size(); ++groups) {
    const std::size_t end = std::min(name.find_first_not_of("0123456789", at), name.size());
    if (end == at || (groups == 0 && end - at != 4) || (groups > 0 && end - at > 2)) {
      break;
    }
    at = end + 1;
  }
  constexpr std::size_t kToTheMinute = 5;
  return groups >= kToTheMinute;
}

bool take_times_from_names(std::vector<ImageFile>& files) {
  std::vector<Stamp> stamps;
  for (const ImageFile& file : files) {
    const auto time = time_in_name(file.path.stem().string());
    if (!time) {
      return false;
    }
    stamps.push_back(*time);
  }
  refuse_doubtful_decimals(files);
  for (std::size_t i = 0; i < files.size(); ++i) {
    files[i].stamp = stamps[i];
  }
  return true;
}

void number(double rate, std::vector<ImageFile>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    files[i].stamp =
        Stamp(std::chrono::nanoseconds(std::llround(static_cast<double>(i) / rate * 1e9)));
  }
}

class ImageFolder final : public ImageSource {
 public:
  ImageFolder(const fs::path& folder, const FolderTimes& times) {
    std::size_t others = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (entry.is_regular_file() && is_image(entry.path())) {
        files_.push_back({entry.path()});
      } else {
        others += entry.path().filename() == "times.csv" ? 0 : 1;
      }
    }
    if (files_.empty()) {
      throw std::runtime_error(folder.string() +
                               ": no image in it (png, jpg, pgm, ppm, bmp or tiff)");
    }
    std::ranges::sort(files_, [](const ImageFile& a, const ImageFile& b) {
      return natural_less(a.path.filename().string(), b.path.filename().string());
    });
    said_.push_back(folder.string() + ": " + std::to_string(files_.size()) + " images" +
                    (others == 0 ? "."
                                 : "; " + std::to_string(others) +
                                       " other files or folders in it are not used."));
    set_times(folder, times);
    std::ranges::stable_sort(files_, {}, &ImageFile::stamp);
  }

  std::optional<SourceImage> next() override {
    while (next_ < files_.size()) {
      const ImageFile& file = files_[next_++];
      try {
        // Turned by EXIF it would not fit the calibration.
        image_ =
            cv::imread(file.path.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
      } catch (const cv::Exception&) {
        image_.release();
      }
      if (image_.empty()) {
        left_out_.push_back({file.path.filename().string(), "the file cannot be decoded"});
        continue;
      }
      return SourceImage{
          .name = file.path.filename().string(),
          .stamp = file.stamp,
          .view = {image_.data, image_.cols, image_.rows, static_cast<int>(image_.step[0])}};
    }
    return std::nullopt;
  }

  [[nodiscard]] std::size_t count() const override { return files_.size(); }
  [[nodiscard]] std::vector<std::string> said() const override { return said_; }
  [[nodiscard]] const std::vector<LeftOut>& left_out() const override { return left_out_; }

 private:
  void set_times(const fs::path& folder, const FolderTimes& times) {
    std::optional<fs::path> table = times.table;
    if (!table && !times.rate && fs::exists(folder / "times.csv")) {
      table = folder / "times.csv";
    }
    if (times.rate) {
      number(*times.rate, files_);
      said_.push_back("Times: " + format_csv_number(*times.rate) +
                      " images per second, in the order of their names.");
    } else if (table) {
      take_times(*table, files_, left_out_, said_);
      said_.push_back("Times: from " + table->string() + ".");
    } else if (take_times_from_names(files_)) {
      said_.emplace_back("Times: from the names of the files.");
    } else {
      number(kAssumedRate, files_);
      said_.push_back("The images have no times: " + format_csv_number(kAssumedRate) +
                      " per second are assumed, in the order of their names (--rate)." +
                      (std::ranges::any_of(files_,
                                           [](const ImageFile& file) {
                                             return holds_a_date(file.path.stem().string());
                                           })
                           ? " Dates in names are not read, since their order is ambiguous "
                             "(--times)."
                           : ""));
    }
  }

  std::vector<ImageFile> files_;
  std::vector<std::string> said_;
  std::vector<LeftOut> left_out_;
  std::size_t next_ = 0;
  cv::Mat image_;
};

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < a.size() && k < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[k])) {
      if (a[i] != b[k]) {
        return a[i] < b[k];
      }
      ++i;
      ++k;
      continue;
    }
    const auto digits = [](std::string_view text, std::size_t& at) {
      const std::size_t begin = std::min(text.find_first_not_of('0', at), text.size());
      at = begin;
      while (at < text.size() && is_digit(text[at])) {
        ++at;
      }
      return text.substr(begin, at - begin);
    };
    const std::string_view left = digits(a, i);
    const std::string_view right = digits(b, k);
    if (left != right) {
      return left.size() != right.size() ? left.size() < right.size() : left < right;
    }
  }
  if (i < a.size() || k < b.size()) {
    return i == a.size();
  }
  return a < b;  // leading zeros
}

std::optional<Stamp> time_in_name(std::string_view stem) {
  std::size_t begin = stem.size();
  while (begin > 0 && is_digit(stem[begin - 1])) {
    --begin;
  }
  const std::string_view digits = stem.substr(begin);
  if (begin > 0 && stem[begin - 1] == '.') {
    std::size_t whole = begin - 1;
    while (whole > 0 && is_digit(stem[whole - 1])) {
      --whole;
    }
    constexpr std::size_t kDigitsOfSeconds = 10;  // from 2001 to 2286
    if (begin - 1 - whole != kDigitsOfSeconds) {
      return std::nullopt;
    }
    const auto seconds = parse_stamp(stem.substr(whole));
    return seconds ? std::optional(Stamp(*seconds)) : std::nullopt;
  }
  struct Unit {
    std::size_t digits;
    std::int64_t nanoseconds;
  };
  for (const Unit unit : {Unit{13, 1'000'000}, Unit{16, 1'000}, Unit{19, 1}}) {
    if (digits.size() == unit.digits) {
      std::int64_t value = 0;
      const auto [end, error] =
          std::from_chars(digits.data(), digits.data() + digits.size(), value);
      constexpr std::int64_t kSeconds = std::int64_t{1} << 31;  // as stamps in CSV
      if (error == std::errc() && value < kSeconds * 1'000'000'000 / unit.nanoseconds) {
        return Stamp(std::chrono::nanoseconds(value * unit.nanoseconds));
      }
    }
  }
  return std::nullopt;
}

std::unique_ptr<ImageSource> open_folder(const fs::path& folder, const FolderTimes& times) {
  return std::make_unique<ImageFolder>(folder, times);
}

}  // namespace pipescout::rack
