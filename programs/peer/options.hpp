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

/// The command line of ddssec-peer; programs/peer/README.md describes it.
struct Options {
  std::string role;
  std::int32_t domain = 0;
  std::string topic;  ///< if it is empty, the default of the role
  std::uint32_t count = 10;
  std::string security = "off";
  std::vector<std::string> interfaces = {"127.0.0.1"};  ///< names or addresses
  double timeout = 30;                                  ///< seconds
  std::uint32_t size = 64;
  double duration = 2;  ///< how long a throughput writer writes, in seconds
  std::string color = "BLUE";
  std::string partition;
  bool verbose = false;
};

/// The parsed options. Empty after usage or --help was printed; then `exit_code` applies.
struct ParsedOptions {
  std::optional<Options> options;
  int exit_code = kUsage;
};
ParsedOptions parse(int argc, char** argv);

}  // namespace ddssec::peer
