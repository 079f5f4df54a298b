// The command line of ddssec-peer and its exit codes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ddssec::peer {

enum Exit : int {
  kDone = 0,
  kNeverMatched = 1,
  kUsage = 2,
  kNotCreated = 3,
  kSamplesMissing = 4,
  kSampleWrong = 5,
};

struct Options {
  std::string role;
  std::int32_t domain = 0;
  std::string topic;  ///< empty: the role's own
  std::uint32_t count = 10;
  std::string security = "off";
  std::vector<std::string> interfaces = {"127.0.0.1"};  ///< names or addresses
  double timeout = 30;                                  ///< seconds
  std::uint32_t size = 64;
  double duration = 2;  ///< seconds a throughput writer writes
  std::string color = "BLUE";
  std::string partition;
  bool verbose = false;
};

/// The options, or the exit code after usage or --help was printed.
struct Parsed {
  std::optional<Options> options;
  int exit_code = kUsage;
};
Parsed parse(int argc, char** argv);

}  // namespace ddssec::peer
