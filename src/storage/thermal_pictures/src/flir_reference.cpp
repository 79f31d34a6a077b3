// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/flir_reference.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {

FlirReferenceErrors score_flir_reference(const std::filesystem::path& folder) {
  const auto read = [&folder](const char* name, const ThermalSettings& settings) {
    return ThermalFileReader(settings).read(folder / name);
  };
  FlirReferenceErrors result;
  ThermalSettings thermacam;
  thermacam.object.emissivity = 0.96;
  result.thermacam = temperature_error(
      read(kFlirReferenceFile, thermacam),
      read_temperature_export(folder / "iguana_ThermaCAM_truth_E0.96_RT20_OD1_RH50_degC.csv.gz"));
  // The export's name says 0.96, but its temperatures are those of the 0.95 in the file, to the
  // last of the digits printed.
  result.research = temperature_error(
      read(kFlirReferenceFile, {}),
      read_temperature_export(folder / "iguana_FLIR_RandD_truth_E0.96_degC.csv.gz"));
  // Those were decoded with the air divided in two halves.
  ThermalSettings midway;
  midway.air_path = thermal::AirPath::kWindowMidway;
  ThermalSettings hundredths;
  hundredths.scale = LinearScale{.gain = 0.01, .offset = -100};
  constexpr std::array kPictures{
      std::pair{"conveyor_zenmuse_xtr.jpg", "conveyor_zenmuse_xtr_degC_x100.png"},
      std::pair{"duo_pro_r_640x512.fff", "duo_pro_r_640x512_degC_x100.png"},
      std::pair{"fluorescent_tubes_t650sc.jpg", "fluorescent_tubes_t650sc_degC_x100.png"},
      std::pair{"iguana_sc660.jpg", "iguana_sc660_degC_x100.png"},
      std::pair{"pipe_ax8.jpg", "pipe_ax8_degC_x100.png"}};
  for (const auto& [name, decoded] : kPictures) {
    const TemperatureError error =
        temperature_error(read(name, midway), read(decoded, hundredths).degrees);
    result.decoded.mean_abs = std::max(result.decoded.mean_abs, error.mean_abs);
    result.decoded.max_abs = std::max(result.decoded.max_abs, error.max_abs);
  }
  return result;
}

}  // namespace pipescout
