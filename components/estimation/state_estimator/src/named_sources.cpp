// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/named_sources.hpp"

#include "pipescout/message_conversions/mounting_parameters.hpp"

namespace pipescout {

namespace {

constexpr FloatingPointRange kLength{0.0, 1e6};

NamedSourceKind kind_named(const std::string& parameter, const std::string& name) {
  const auto kind = named_source_kind(name);
  if (!kind) {
    throw ParameterError(parameter, "parameter '" + parameter + "': '" + name + "' is not one of " +
                                        all_named_source_kinds());
  }
  return *kind;
}

}  // namespace

NamedSourceParameters::NamedSourceParameters(Parameters& parameters) {
  const auto names =
      parameters
          .declare<std::vector<std::string>>(
              "sources", {},
              {.description = "names of further sources; parameters of each begin with its name",
               .read_only = true})
          .get();
  for (const std::string& name : names) {
    const auto number = [&](const char* what, double value, FloatingPointRange range,
                            const char* description) {
      return parameters.declare<double>(
          name + "." + what, value, {.description = description, .floating_point_range = range});
    };
    const auto numbers = [&](const char* what, const char* description) {
      return parameters.declare<std::vector<double>>(name + "." + what, {},
                                                     {.description = description});
    };
    const auto kind = kind_named(
        name + ".kind",
        parameters
            .declare_required<std::string>(
                name + ".kind",
                {.description = "what it measures, and by which message", .read_only = true})
            .get());
    const auto joints = [&](const char* side) {
      return parameters.declare<std::vector<std::string>>(
          name + "." + side, {},
          {.description =
               std::string("joints of the wheels on the ") + side + ", of wheel_encoders"});
    };
    const NamedSource defaults = default_source(name, kind);
    std::vector<Parameter<double>> all;
    for (const NamedSourceNumber& each : named_source_numbers()) {
      all.push_back(
          number(each.key, defaults.*each.field, {each.low, each.high}, each.description));
    }
    declared_.push_back(
        {.name = name,
         .kind = kind,
         .topic =
             parameters.declare<std::string>(name + ".topic", name, {.description = "its topic"}),
         .position = numbers("position", "m, in the base frame; empty: from tf"),
         .roll_pitch_yaw = numbers("roll_pitch_yaw", "rad, with a position; empty: 0 0 0"),
         .beacon = numbers("beacon", "m, of the beacon of a range, in the map"),
         .numbers = std::move(all),
         .left = joints("left"),
         .right = joints("right"),
         .wheel_radius = number("wheel_radius", 0, kLength, "m, of wheel_encoders"),
         .track =
             number("track", 0, kLength, "m between the wheels of both sides, of wheel_encoders")});
  }
}

std::vector<NamedSource> NamedSourceParameters::read(
    estimation::StateEstimatorParameters& estimator) const {
  std::vector<NamedSource> sources;
  for (const Declared& declared : declared_) {
    NamedSource& source = sources.emplace_back(default_source(declared.name, declared.kind));
    source.topic = declared.topic.get();
    source.position = three(declared.position);
    source.R_base_sensor = geometry::SO3::from_roll_pitch_yaw(
        three(declared.roll_pitch_yaw).value_or(Eigen::Vector3d::Zero()));
    source.beacon = three(declared.beacon);
    const auto numbers = named_source_numbers();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      source.*numbers[i].field = declared.numbers[i].get();
    }
    source.wheels = {.left = declared.left.get(),
                     .right = declared.right.get(),
                     .wheel_radius = declared.wheel_radius.get(),
                     .track = declared.track.get()};
  }
  place_sources(sources, estimator);
  return sources;
}

}  // namespace pipescout
