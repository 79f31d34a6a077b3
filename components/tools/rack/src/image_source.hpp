// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/csv/csv_stamp.hpp"
#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack {

struct SourceImage {
  std::string name;  ///< of the file; in a bag the number of the message and its topic
  Stamp stamp{};
  rack_vision::ImageView view;  ///< valid until the next call of ImageSource::next
};

/// Something that was not used, with the reason.
struct LeftOut {
  std::string name;
  std::string reason;
};

/// Grey images in the order of time. Not thread-safe.
class ImageSource {
 public:
  virtual ~ImageSource() = default;

  /// Nothing after the last image. Images that cannot be read are passed over and are then in
  /// `left_out`.
  [[nodiscard]] virtual std::optional<SourceImage> next() = 0;
  /// How many images there are, those that cannot be read included.
  [[nodiscard]] virtual std::size_t count() const = 0;
  /// Sentences for the report: what the images are and where their times come from.
  [[nodiscard]] virtual std::vector<std::string> said() const = 0;
  [[nodiscard]] virtual const std::vector<LeftOut>& left_out() const = 0;
};

}  // namespace pipescout::rack
