// SPDX-License-Identifier: Apache-2.0
#include "program.hpp"

#include <benchmark/benchmark.h>

#include <cstring>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

namespace pipescout::benchmarks {

int run_program(int argc, char** argv, const std::function<void()>& register_cases,
                const std::function<Figures()>& evaluate) {
  std::string json;
  std::vector<char*> arguments;
  std::string repetitions = "--benchmark_repetitions=10";
  std::string interleave = "--benchmark_enable_random_interleaving=true";
  std::string aggregates = "--benchmark_display_aggregates_only=true";
  arguments.push_back(argv[0]);
  arguments.push_back(repetitions.data());
  arguments.push_back(interleave.data());
  arguments.push_back(aggregates.data());
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
      json = argv[++i];
    } else {
      arguments.push_back(argv[i]);
    }
  }
  try {
    int count = static_cast<int>(arguments.size());
    benchmark::Initialize(&count, arguments.data());
    if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) {
      return 2;
    }
    register_cases();
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    const Figures figures = evaluate();
    figures.print(std::cout);
    if (!json.empty()) {
      figures.write_json(json);
    }
  } catch (const std::exception& error) {
    std::cerr << argv[0] << ": " << error.what() << '\n';
    return 1;
  }
  return 0;
}

}  // namespace pipescout::benchmarks
