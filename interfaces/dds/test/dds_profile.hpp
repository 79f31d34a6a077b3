// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace pipescout::dds_test {

/// Makes the participants of this test program meet over the wire, as those of two processes do:
/// Fast DDS would hand samples over directly. Has profiles for the topic "/profiled" as well. Reads
/// as a user's profile file, so it has to be there before the first participant.
class WireOnlyProfile {
 public:
  WireOnlyProfile()
      : file_(std::filesystem::temp_directory_path() /
              ("pipescout_wire_only_" + std::to_string(getpid()) + ".xml")) {
    std::ofstream(file_) << R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <library_settings><intraprocess_delivery>OFF</intraprocess_delivery></library_settings>
  <profiles>
    <data_writer profile_name="/profiled">
      <qos>
        <publishMode><kind>ASYNCHRONOUS</kind></publishMode>
        <ownership><kind>EXCLUSIVE</kind></ownership>
      </qos>
      <throughputController>
        <bytesPerPeriod>65536</bytesPerPeriod>
        <periodMillisecs>1</periodMillisecs>
      </throughputController>
    </data_writer>
    <data_reader profile_name="/profiled">
      <qos><ownership><kind>EXCLUSIVE</kind></ownership></qos>
    </data_reader>
  </profiles>
</dds>
)";
    setenv("FASTRTPS_DEFAULT_PROFILES_FILE", file_.c_str(), 1);
  }
  WireOnlyProfile(const WireOnlyProfile&) = delete;
  WireOnlyProfile& operator=(const WireOnlyProfile&) = delete;
  ~WireOnlyProfile() {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }

 private:
  std::filesystem::path file_;
};

inline const WireOnlyProfile wire_only_profile;

}  // namespace pipescout::dds_test
