// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Parameters of a component that correspond to the fields of one struct: declared with the values
/// of a given struct, for example a preset, as defaults, and read into another one.
template <class Struct>
class BoundParameters {
 public:
  template <class T>
  using Field = std::function<T&(Struct&)>;

  /// `defaults`: struct with the default values of the parameters.
  BoundParameters(Parameters& parameters, Struct defaults)
      : parameters_(&parameters), defaults_(std::move(defaults)) {}

  void real(const std::string& name, Field<double> field, FloatingPointRange range,
            const std::string& description) {
    reals_.push_back(
        {parameters_->declare<double>(name, field(defaults_),
                                      {.description = description, .floating_point_range = range}),
         std::move(field)});
  }
  void integer(const std::string& name, Field<int> field, IntegerRange range,
               const std::string& description) {
    integers_.push_back(
        {parameters_->declare<int>(name, field(defaults_),
                                   {.description = description, .integer_range = range}),
         std::move(field)});
  }
  void count(const std::string& name, Field<std::size_t> field, IntegerRange range,
             const std::string& description) {
    counts_.push_back(
        {parameters_->declare<std::size_t>(name, field(defaults_),
                                           {.description = description, .integer_range = range}),
         std::move(field)});
  }
  void boolean(const std::string& name, Field<bool> field, const std::string& description) {
    booleans_.push_back(
        {parameters_->declare<bool>(name, field(defaults_), {.description = description}),
         std::move(field)});
  }

  /// The defaults overwritten with the current values of the parameters.
  [[nodiscard]] Struct read() const {
    Struct result = defaults_;
    const auto copy = [&result](const auto& bound) {
      for (const auto& [parameter, field] : bound) {
        field(result) = parameter.get();
      }
    };
    copy(reals_);
    copy(integers_);
    copy(counts_);
    copy(booleans_);
    return result;
  }

 private:
  template <class T>
  struct Bound {
    Parameter<T> parameter;
    Field<T> field;
  };

  Parameters* parameters_;
  Struct defaults_;
  std::vector<Bound<double>> reals_;
  std::vector<Bound<int>> integers_;
  std::vector<Bound<std::size_t>> counts_;
  std::vector<Bound<bool>> booleans_;
};

}  // namespace pipescout
