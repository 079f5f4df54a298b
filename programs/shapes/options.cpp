#include "programs/shapes/options.hpp"

#include <CLI/CLI.hpp>
#include <limits>
#include <map>

namespace ddssec::shapes {
namespace {

using Kinds = std::map<std::string, rtps::DurabilityKind>;
using Scopes = std::map<std::string, rtps::PresentationScope>;
using States = std::map<std::string, FinalState>;
using Representations = std::map<std::string, rtps::DataRepresentation>;

constexpr std::int64_t kMaxMilliseconds = std::numeric_limits<std::int32_t>::max();

template <class T>
auto at_least(T min) {
  return CLI::Range(min, std::numeric_limits<T>::max());
}

// CLI11's own support for enumerations also lists numbers.
template <class T>
void add_choice(CLI::App& app, const std::string& name, T& value, std::map<std::string, T> choices,
                const std::string& help) {
  std::vector<std::string> names;
  for (const auto& [key, unused] : choices) names.push_back(key);
  app.add_option_function<std::string>(
         name, [&value, choices](const std::string& key) { value = choices.at(key); }, help)
      ->check(CLI::IsMember(names));
}

void add_qos(CLI::App& app, Options& o) {
  app.add_flag_callback(
      "-b", [&o] { o.reliable = false; }, "BEST_EFFORT reliability");
  app.add_flag_callback(
      "-r", [&o] { o.reliable = true; }, "RELIABLE reliability (default)");
  app.add_option("-k", o.history_depth, "history depth; 0: KEEP_ALL")->check(at_least(0));
  app.add_option("-f", o.deadline, "deadline in milliseconds")
      ->check(CLI::Range(std::int64_t{0}, kMaxMilliseconds));
  app.add_option("-s", o.ownership_strength, "-1: SHARED (default), else EXCLUSIVE")
      ->check(at_least(-1));
  app.add_option("-p", o.partition, "partition");
  add_choice(app, "-D", o.durability,
             Kinds{{"v", rtps::DurabilityKind::volatile_},
                   {"l", rtps::DurabilityKind::transient_local},
                   {"t", rtps::DurabilityKind::transient},
                   {"p", rtps::DurabilityKind::persistent}},
             "durability: VOLATILE, TRANSIENT_LOCAL, TRANSIENT, PERSISTENT");
  app.add_option("--durability-directory", o.durability_directory,
                 "with -D p: where a publisher keeps its samples; without, they end with it");
  add_choice(app, "-x", o.representation,
             Representations{{"1", rtps::DataRepresentation::xcdr1},
                             {"2", rtps::DataRepresentation::xcdr2}},
             "data representation: XCDR1, XCDR2");
  app.add_option("--time-filter", o.time_filter, "least separation of samples in milliseconds")
      ->check(CLI::Range(std::int64_t{0}, kMaxMilliseconds));
  app.add_option("--lifespan", o.lifespan, "lifespan of samples in milliseconds")
      ->check(CLI::Range(std::int64_t{0}, kMaxMilliseconds));
  add_choice(app, "--access-scope", o.presentation.scope,
             Scopes{{"i", rtps::PresentationScope::instance},
                    {"t", rtps::PresentationScope::topic},
                    {"g", rtps::PresentationScope::group}},
             "presentation: INSTANCE, TOPIC, GROUP");
  app.add_flag("--coherent", o.presentation.coherent_access, "coherent access");
  app.add_flag("--ordered", o.presentation.ordered_access, "ordered access");
}

void add_samples(CLI::App& app, Options& o) {
  app.add_option("-t", o.topic, "topic name (default Square)");
  app.add_option("-c", o.color, "colour to publish; of a subscriber: filter");
  app.add_flag("-w", o.print_written, "print written samples");
  app.add_option("-z", o.size, "shape size; 0: grows by one a write from 1")->check(at_least(0));
  app.add_option("--size-modulo", o.size_modulo, "with -z 0: sizes go from 1 to this")
      ->check(at_least(1));
  app.add_option("--num-iterations", o.iterations, "writes or reads, then the end; 0: no end");
  app.add_option("--num-instances", o.instances, "instances to write: COLOR, COLOR1...")
      ->check(CLI::Range(1u, 1000000u));
  app.add_option("--num-topics", o.topics, "topics: TOPIC, TOPIC1...")
      ->check(CLI::Range(1u, 1000u));
  add_choice(
      app, "--final-instance-state", o.final_state,
      States{{"u", FinalState::unregistered}, {"d", FinalState::disposed}},
      "what a publisher does with its instances at the end: u unregisters, d disposes; without "
      "it, they are unregistered as the writer leaves");
  app.add_option("--coherent-sample-count", o.coherent_samples, "iterations in a coherent set")
      ->check(at_least(2u));
  app.add_option("--additional-payload-size", o.payload_size, "octets added to each sample")
      ->check(CLI::Range(1u, 64u << 20));
  app.add_option("--cft", o.filter, "content filter expression");
  app.add_flag("--final", o.final_type, "a final type without additional payload");
}

void add_timing(CLI::App& app, Options& o) {
  app.add_flag("-R", o.read, "read instead of take");
  app.add_flag_callback(
      "--take-read", [&o] { o.by_instance = false; },
      "take/read instead of take_next_instance/read_next_instance");
  app.add_option("--write-period", o.write_period, "milliseconds between writes (33)")
      ->check(CLI::Range(std::int64_t{0}, kMaxMilliseconds));
  app.add_option("--read-period", o.read_period, "milliseconds between reads (100)")
      ->check(CLI::Range(std::int64_t{0}, kMaxMilliseconds));
  app.add_option("--periodic-announcement", o.announcement_period,
                 "milliseconds between participant announcements")
      ->check(CLI::Range(std::int64_t{1}, kMaxMilliseconds));
  app.add_option("--datafrag-size", o.fragment_size, "octets of a fragment of large samples")
      ->check(CLI::Range(1u, 65000u));
}

// Returns a message if options contradict each other; empty if they do not.
std::string contradiction(const Options& o) {
  if (o.final_type && o.payload_size > 0) return "--final has no additional payload";
  if (!o.filter.empty() && !o.color.empty() && !o.publish) return "--cft and -c are both filters";
  return {};
}

}  // namespace

ParsedOptions parse(int argc, char** argv) {
  Options options;
  bool subscribe = false;
  CLI::App app("Publishes or subscribes to coloured shapes; one line a sample.", "ddssec-shapes");
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  auto* role = app.add_option_group("role")->require_option(1);
  role->add_flag("-P", options.publish, "publish");
  role->add_flag("-S", subscribe, "subscribe");
  app.add_option("-d", options.domain, "domain (default 0)")->check(CLI::Range(0, kMaxDomainId));
  add_choice(app, "-v", options.verbose, std::map<std::string, bool>{{"e", false}, {"d", true}},
             "verbosity: errors, debug (to standard error)");
  app.add_option("--interface", options.interfaces,
                 "name or address of an interface to use, may be repeated; default: all that are up"
                 " and do multicast")
      ->take_all();
  app.add_option("--security", options.security, "folder with keys and documents, or off");
  add_qos(app, options);
  add_samples(app, options);
  add_timing(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error) == 0 ? int{kDone} : int{kBadArguments}};
  }
  if (const auto words = contradiction(options); !words.empty()) {
    std::fprintf(stderr, "ddssec-shapes: %s\n", words.c_str());
    return {};
  }
  if (options.publish && options.color.empty()) options.color = "BLUE";
  return {options, kDone};
}

}  // namespace ddssec::shapes
