// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pipescout/runtime/parameter_value.hpp"

namespace pipescout::summary {

/// What a composition says under `summary` of the tables of its mission. Paths are relative to the
/// working folder. docs/mission_folder.md
struct TableOptions {
  struct Crawler {
    bool signal = true;            ///< the samples of the eddy currents too, which are many
    std::size_t table_rows = 100;  ///< welds in the section; the file has all
  };
  struct Rack {
    double image_period = 1.0;  ///< s, from one image to the next; 0: none
    std::size_t maximum_images = 600;
    std::filesystem::path rack;  ///< file with the pipes, copied to the tables; empty: none
  };
  struct Odometry {
    std::filesystem::path reference_file;        ///< CSV, a row for each reading; empty: none
    std::vector<std::string> reference_columns;  ///< the first of these that it has is taken
    std::size_t table_rows = 200;                ///< readings in the section; the files have all
    std::vector<std::string> notes;              ///< sentences below the table
  };
  struct Tracking {
    double picture_interval = 0.8;  ///< s, from one picture to the next; 0: none
    std::size_t maximum_pictures = 600;
  };
  struct Estimator {
    double period = 0.1;        ///< s, from one pose to the next; 0: all
    std::vector<double> datum;  ///< degrees, degrees, m: origin of the map; empty: as the estimator
                                ///< tells it on tf, else the first fix
  };

  Crawler crawler;
  Rack rack;
  Odometry odometry;
  Tracking tracking;
  Estimator estimator;
};

/// Names as "rack.image_period". Throws std::invalid_argument naming what is unknown, has another
/// type or is out of range, with its place.
[[nodiscard]] TableOptions read_table_options(std::span<const ParameterOverride> options);

}  // namespace pipescout::summary
