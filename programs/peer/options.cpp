#include "programs/peer/options.hpp"

#include <CLI/CLI.hpp>

namespace ddssec::peer {

ParsedOptions parse(int argc, char** argv) {
  Options options;
  CLI::App app(
      "One end of a DDS connection, for tests and measurements. Prints JSON,"
      " one object a line.",
      "ddssec-peer");
  app.add_option("--role", options.role, "what to do")
      ->required()
      ->check(CLI::IsMember({"pub", "sub", "ping", "pong", "tput-pub", "tput-sub"}));
  app.add_option("--domain", options.domain, "DDS domain")
      ->required()
      ->check(CLI::Range(0, kMaxDomainId));
  app.add_option("--topic", options.topic, "topic name; default Square, or the role's own");
  app.add_option("--count", options.count, "samples, or round trips");
  app.add_option("--security", options.security, "folder with keys and documents, or off");
  app.add_option("--interface", options.interfaces,
                 "name or address of an interface to use, may be repeated; default: the loopback")
      ->take_all();
  app.add_option("--timeout", options.timeout, "seconds after which to end")
      ->check(CLI::PositiveNumber);
  app.add_option("--size", options.size, "octets of payload")->check(CLI::Range(0, 64 << 20));
  app.add_option("--duration", options.duration, "seconds to write (tput-pub)")
      ->check(CLI::PositiveNumber);
  app.add_option("--color", options.color, "the instance to write (pub)");
  app.add_option("--partition", options.partition, "partition name");
  app.add_flag("--verbose", options.verbose, "log every event to standard error");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error) == 0 ? int{kDone} : int{kUsage}};
  }
  return {options, kDone};
}

}  // namespace ddssec::peer
