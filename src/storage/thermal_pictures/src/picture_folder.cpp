// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/picture_folder.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace pipescout {
namespace {

namespace fs = std::filesystem;

/// Formats of thermal cameras that are known by name alone.
bool is_unread_recording(const fs::path& file) {
  constexpr std::array kUnread{".ats", ".sfmov", ".is2", ".is3", ".irb", ".bmt",
                               ".irg", ".avi",   ".mp4", ".mov", ".mkv", ".raw"};
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return std::ranges::find(kUnread, extension) != kUnread.end();
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The digits that a text begins with, without leading zeros; takes them off.
std::string_view take_number(std::string_view& text) {
  const auto end = std::ranges::find_if_not(text, is_digit);
  std::string_view digits = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(digits.size());
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

/// Asks the files whose time nobody has told.
std::string ask_times(std::vector<FolderPicture>& pictures, const ThermalFileReader& reader) {
  std::vector<fs::path> files;
  std::vector<FolderPicture*> asked;
  for (FolderPicture& picture : pictures) {
    if (!picture.taken) {
      files.push_back(picture.file);
      asked.push_back(&picture);
    }
  }
  try {
    const auto times = reader.times(files);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      asked[i]->taken = times[i];
    }
  } catch (const ThermalFileError& error) {
    return std::string("images are in the order of their names: ") + error.what();
  }
  return "";
}

}  // namespace

std::string FolderPicture::name() const {
  const std::string name = file.filename().string();
  return frames && frames->size() > 1 ? name + "#" + std::to_string(frame + 1) : name;
}

bool natural_less(const std::string& a, const std::string& b) {
  std::string_view one = a;
  std::string_view other = b;
  while (!one.empty() && !other.empty()) {
    if (is_digit(one.front()) && is_digit(other.front())) {
      const std::string_view first = take_number(one);
      const std::string_view second = take_number(other);
      if (first != second) {
        return first.size() != second.size() ? first.size() < second.size() : first < second;
      }
    } else if (one.front() != other.front()) {
      return one.front() < other.front();
    } else {
      one.remove_prefix(1);
      other.remove_prefix(1);
    }
  }
  // "01" and "1" count the same, and are two files.
  return one.empty() && other.empty() ? a < b : one.empty();
}

PictureFolder pictures_in(const fs::path& folder, const ToldTimes& told,
                          const ThermalFileReader& reader) {
  std::error_code error;
  PictureFolder result;
  std::vector<FolderPicture> files;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->is_directory()) {
      continue;
    }
    if (has_thermal_extension(at->path())) {
      files.push_back({.file = at->path()});
    } else if (is_unread_recording(at->path())) {
      result.unread.push_back(at->path().filename().string());
    }
  }
  if (error) {
    throw std::runtime_error(folder.string() + ": " + error.message());
  }
  std::ranges::sort(result.unread, natural_less);
  if (files.empty()) {
    throw std::runtime_error(
        folder.string() +
        ": contains no image: no .jpg, .jpeg, .fff, .seq, .csq, .png, .tif or .tiff" +
        (result.unread.empty() ? ""
                               : "; recordings as " + result.unread.front() + " are not read"));
  }
  std::ranges::sort(files, [](const FolderPicture& a, const FolderPicture& b) {
    return natural_less(a.file.filename().string(), b.file.filename().string());
  });
  for (FolderPicture& file : files) {
    file.frames =
        std::make_shared<const std::vector<FrameExtent>>(ThermalFileReader::frames(file.file));
    file.taken = told(file.name());
  }
  result.problem = ask_times(files, reader);
  for (const FolderPicture& file : files) {
    std::optional<double> taken = file.taken;
    for (std::size_t frame = 0; frame < file.frames->size(); ++frame) {
      FolderPicture& picture = result.pictures.emplace_back(file);
      picture.frame = frame;
      if (file.frames->size() > 1) {
        // A frame that does not tell follows the one before.
        const auto known = told(picture.name());
        taken = known ? known : (*file.frames)[frame].taken ? (*file.frames)[frame].taken : taken;
      }
      picture.taken = taken;
    }
  }
  std::ranges::stable_sort(result.pictures, [](const FolderPicture& a, const FolderPicture& b) {
    constexpr double kLast = std::numeric_limits<double>::infinity();
    return a.taken.value_or(kLast) < b.taken.value_or(kLast);
  });
  return result;
}

}  // namespace pipescout
