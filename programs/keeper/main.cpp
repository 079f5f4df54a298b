// ddssec-keeper: a durability service. Stores the samples of TRANSIENT and PERSISTENT writers of a
// domain in a file, and gives them to late joiners, even after those writers are gone.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "rtps/keeper/keeper.hpp"
#include "secured/runtime.hpp"

namespace {

using namespace ddssec;

enum Exit : int { kDone = 0, kBadArguments = 1, kNotInitialised = 2, kNotStored = 3 };

constexpr auto kMaxFlush = std::chrono::seconds(5);

struct Options {
  std::int32_t domain = 0;
  rtps::KeeperOptions keeper;
  std::string security = "off";
  std::vector<std::string> interfaces = {};
};

class Log final : public EventSink {
 public:
  void raise(const Event& event) override {
    // print_refusal() prints an error that is also returned.
    if (!event.is_returned) std::fprintf(stderr, "%s\n", event.to_line().c_str());
  }
};

sigset_t hold_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is treated like a full disk
  return set;
}

Result<rtps::DomainParticipantOptions> participant_options(const Options& options,
                                                           secured::SecurityPluginSet& plugins) {
  rtps::DomainParticipantOptions out{.domain_id = options.domain,
                                     .entity_name = "ddssec-keeper",
                                     .interfaces = options.interfaces};
  if (options.security != "off") {
    DDSSEC_ASSIGN_OR_RETURN(auto security, plugins.security_options(options.security));
    out.security.emplace(std::move(security));
  }
  return out;
}

int print_refusal(const Error& error) {
  std::fprintf(stderr, "ddssec-keeper: %s\n", error.to_sentence().c_str());
  return kNotInitialised;
}

// Prints the numbers of samples that were received but not stored. If there are none, the file has
// everything that was acknowledged.
int finish(rtps::Keeper& keeper, EventSink& events) {
  const auto stored = keeper.flush(kMaxFlush);
  const auto topics = keeper.topics();
  const auto unstored = keeper.unstored();
  if (const auto count = keeper.without_key(); count > 0)
    std::printf("Not kept: %llu samples without key hash\n",
                static_cast<unsigned long long>(count));
  if (const auto count = keeper.left_out(); count > 0)
    std::printf("Not kept: %llu samples beyond DURABILITY_SERVICE\n",
                static_cast<unsigned long long>(count));
  if (const auto count = keeper.dropped(); count > 0)
    std::printf("Not kept: %llu samples that are too large\n",
                static_cast<unsigned long long>(count));
  if (const auto count = keeper.abandoned(); count > 0)
    std::printf("Not kept: %llu samples that waited for room when their writers left\n",
                static_cast<unsigned long long>(count));
  if (stored && unstored == 0) {
    std::printf("Done: %zu topics kept\n", topics);
    return kDone;
  }
  std::printf("Lost: %llu samples are not stored; none of them was acknowledged\n",
              static_cast<unsigned long long>(unstored));
  events.raise(
      Event(Error(Code::rtps_samples_not_stored,
                  {.expected = "all samples in the store",
                   .found = std::to_string(unstored) + " that are not: " +
                            (stored ? "the share of their identity is full, or they came last"
                                    : stored.error().to_sentence())})));
  return kNotStored;
}

int run(const Options& options) {
  const auto signals = hold_signals();
  Log log;
  secured::Runtime runtime(log);
  auto wanted = participant_options(options, runtime.plugins());
  if (!wanted) return print_refusal(wanted.error());
  auto keeper = rtps::Keeper::create(*std::move(wanted), options.keeper, runtime.services());
  if (!keeper) return print_refusal(keeper.error());
  std::printf("Keeping domain %d: %zu topics known\n", options.domain, (*keeper)->topics());
  std::fflush(stdout);
  int signal = 0;
  sigwait(&signals, &signal);
  return finish(**keeper, runtime.events());
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "A durability service: keeps what TRANSIENT and PERSISTENT writers write and gives it to late"
      " joiners, whether those writers are still there or not.",
      "ddssec-keeper");
  app.add_option("-d,--domain", options.domain, "DDS domain (default 0)")
      ->check(CLI::Range(0, kMaxDomainId));
  app.add_option("--store", options.keeper.store, "file to keep samples in; none: memory");
  app.add_option("--store-octets", options.keeper.store_octets, "most octets of the store");
  app.add_option("-t,--topic", options.keeper.topics,
                 "topic to keep, may have * and ?; default all");
  app.add_option("--security", options.security, "folder with keys and documents, or off");
  app.add_option("--interface", options.interfaces,
                 "name or address of an interface to use, may be repeated; default: all that are up"
                 " and do multicast")
      ->take_all();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? int{kDone} : int{kBadArguments};
  }
  return run(options);
}
