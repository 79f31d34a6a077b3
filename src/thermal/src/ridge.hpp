// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "pipescout/thermal/leak_detector.hpp"
#include "scale.hpp"

namespace pipescout::thermal {

/// The longest straight ridge of a picture, warmer than both of its sides: levels of it, a low
/// quantile along it, and of the warmer side, the median. NaN where there is none.
struct Ridge {
  double level = std::numeric_limits<double>::quiet_NaN();
  double side = std::numeric_limits<double>::quiet_NaN();
};

/// Finds it on a few columns and rows: on each of them the part that exceeds what is on either side
/// of it most. Those on one line are the ridge. Neither a dead pixel nor a leak moves
/// them.
class RidgeFinder {
 public:
  template <class Pixel>
  Ridge find(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
             const LeakDetectorParameters& parameters);

 private:
  struct Crest {
    double across = 0;  // pixels, along the column or row
    double along = 0;   // of which column or row
    double level = 0;
    double side = 0;
    double width = 0;
  };
  template <class Pixel>
  void find_crests(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                   const LeakDetectorParameters& parameters, bool columns);
  void add_crest(double along, int most_width, const LeakDetectorParameters& parameters);
  /// Keeps the crests on one line; returns how long it is, pixels.
  double keep_line();
  [[nodiscard]] Ridge levels();

  std::vector<double> sums_;  // of the values before each place
  std::vector<Crest> crests_;
  std::vector<Crest> best_;
  std::vector<double> values_;
};

extern template Ridge RidgeFinder::find(const TemperatureView&, const Scale<float>&,
                                        const LeakDetectorParameters&);
extern template Ridge RidgeFinder::find(const CountView&, const Scale<std::uint16_t>&,
                                        const LeakDetectorParameters&);
extern template Ridge RidgeFinder::find(const GreyView&, const Scale<std::uint8_t>&,
                                        const LeakDetectorParameters&);

}  // namespace pipescout::thermal
