// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <clocale>
#include <cstdlib>
#include <locale>
#include <stdexcept>
#include <string>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::testing {

/// As a program that has set its locale: 1234.5 is "1.234,5" for C++ streams, std::to_string,
/// printf, strtod. Until the end of the test. C's part is made by localedef from Debian's package
/// locales.
class CommaLocale {
 public:
  CommaLocale() : before_(std::setlocale(LC_ALL, nullptr)) {
    const std::string command =
        "localedef -i de_DE -f UTF-8 '" + (folder_.path() / kName).string() + "' >/dev/null 2>&1";
    if (std::system(command.c_str()) != 0) {
      throw std::runtime_error("localedef cannot make de_DE; is the package locales installed?");
    }
    ::setenv("LOCPATH", folder_.path().c_str(), 1);
    if (std::setlocale(LC_ALL, kName) == nullptr) {
      throw std::runtime_error("the locale that localedef has made cannot be set");
    }
    // A locale without a name, which leaves C's as it is.
    old_ = std::locale::global(std::locale(std::locale::classic(), new Numbers));
  }
  ~CommaLocale() {
    std::locale::global(old_);
    std::setlocale(LC_ALL, before_.c_str());
    ::unsetenv("LOCPATH");
  }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

  /// For LOCPATH and LC_ALL of other programs.
  [[nodiscard]] std::string folder() const { return folder_.path().string(); }
  static constexpr const char* kName = "de_DE.UTF-8";

 private:
  class Numbers : public std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };

  TemporaryFolder folder_;
  std::string before_;
  std::locale old_;
};

}  // namespace pipescout::testing
