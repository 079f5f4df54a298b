// The command line of benchmarks, as pairs of an option and its value, and their exit codes.
#pragma once

#include <cstdio>
#include <exception>
#include <initializer_list>
#include <map>
#include <string>

namespace ddssec::bench {

using Options = std::map<std::string, std::string>;

/// Returns the exit code: that of `run`, 1 if it throws, 2 if a required option is missing.
inline int main_of(int argc, char** argv, Options options,
                   std::initializer_list<const char*> needed, int (*run)(const Options&)) {
  for (int i = 1; i + 1 < argc; i += 2) options[argv[i]] = argv[i + 1];
  for (const auto* one : needed)
    if (!options.contains(one)) {
      std::fprintf(stderr, "%s: %s PATH is missing\n", argv[0], one);
      return 2;
    }
  try {
    return run(options);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "%s: %s\n", argv[0], failure.what());
    return 1;
  }
}

}  // namespace ddssec::bench
