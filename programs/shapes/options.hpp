// The command line of ddssec-shapes and its exit codes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rtps/qos/qos.hpp"

namespace ddssec::shapes {

enum Exit : int { kDone = 0, kBadArguments = 1, kNotInitialised = 2, kRunFailed = 3 };

enum class FinalState : std::uint8_t { as_it_is, unregistered, disposed };

/// Periods are in milliseconds. An option is empty (or 0, for --time-filter and --lifespan) if it
/// was not given.
struct Options {
  bool publish = false;
  std::int32_t domain = 0;
  bool reliable = true;
  std::optional<std::int32_t> history_depth = {};  ///< 0 means keep all
  std::optional<std::int64_t> deadline = {};
  std::int32_t ownership_strength = -1;  ///< -1 means shared
  std::string topic = "Square";
  std::string color;  ///< the colour to publish; for a subscriber, the only one to receive
  std::string partition;
  rtps::DurabilityKind durability = rtps::DurabilityKind::volatile_;
  rtps::DataRepresentation representation = rtps::DataRepresentation::xcdr1;
  std::string durability_directory;  ///< if it is empty, samples last as long as the publisher
  bool print_written = false;
  std::int32_t size = 20;  ///< with 0 it grows by one with each write
  bool read = false;       ///< read samples instead of taking them
  bool by_instance = true;
  bool verbose = false;
  std::int64_t write_period = 33;
  std::int64_t read_period = 100;
  std::int64_t time_filter = 0;
  std::int64_t lifespan = 0;
  std::uint64_t iterations = 0;  ///< 0 means until SIGINT
  std::uint32_t instances = 1;
  std::uint32_t topics = 1;
  FinalState final_state = FinalState::as_it_is;
  rtps::Presentation presentation = {};
  std::uint32_t coherent_samples = 0;
  std::uint32_t payload_size = 0;
  std::optional<std::int64_t> announcement_period = {};
  std::optional<std::uint32_t> fragment_size = {};
  std::string filter;                        ///< the expression of a content filter
  std::vector<std::string> interfaces = {};  ///< names or addresses; empty: every interface
  std::string security = "off";              ///< "off", or a folder with keys and documents
  std::int32_t size_modulo = 0;
  bool final_type = false;

  /// Returns NAME, NAME1, NAME2...
  static std::string numbered(const std::string& name, std::uint32_t i) {
    return i == 0 ? name : name + std::to_string(i);
  }
};

/// The parsed options. Empty after usage or --help was printed; then `exit_code` applies.
struct ParsedOptions {
  std::optional<Options> options;
  int exit_code = kBadArguments;
};
ParsedOptions parse(int argc, char** argv);

}  // namespace ddssec::shapes
