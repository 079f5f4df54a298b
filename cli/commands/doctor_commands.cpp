// doctor: finds everything that is wrong with a participant's folder, for each product.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.hpp"
#include "cli/commands/groups.hpp"
#include "cli/doctor/doctor_options.hpp"
#include "cli/doctor/folder_configuration.hpp"
#include "cli/doctor/key_passwords.hpp"
#include "cli/doctor/meeting_report.hpp"
#include "cli/doctor/participant_diagnosis.hpp"
#include "cli/doctor/pre_shared_keys.hpp"
#include "cli/doctor/products.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "governance/doctor/cyclonedds_shared_memory.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/host_plugins.hpp"
#include "governance/doctor/lint_checks.hpp"
#include "governance/doctor/named_files.hpp"
#include "governance/doctor/plugin_probe.hpp"
#include "governance/doctor/ros_environment.hpp"
#include "governance/doctor/transport.hpp"
#include "governance/doctor/writable_places.hpp"
#include "governance/model.hpp"
#include "plugins/spi/process_properties.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;
using doctor::Product;

// Findings about products without a column (OpenDDS) are shown unless --vendor is given.
bool concerns(const Finding& finding, const Products& products) {
  return finding.products.empty() || std::ranges::any_of(finding.products, [&](const auto& word) {
           const auto product = doctor::product_from(word);
           return product ? std::ranges::find(products.list, *product) != products.list.end()
                          : products.list.size() == doctor::kProducts.size();
         });
}

Json verdicts_json(const doctor::Outcomes& outcomes, const Products& products) {
  Json out = Json::object();
  for (const auto product : products.list)
    out[doctor::id(product, products.lineup)] = to_string(outcomes.of(product));
  return out;
}

constexpr std::size_t kMinTitleWidth = 54;
constexpr std::size_t kColumnWidth = 19;

std::string row(std::string_view title, const doctor::Outcomes& outcomes, const Products& products,
                std::size_t title_width) {
  auto out = fmt::format("{:<{}} ", title, title_width);
  for (const auto product : products.list)
    out += fmt::format("{:<{}}", to_string(outcomes.of(product)), kColumnWidth);
  return out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
}

bool is_good(const doctor::Outcomes& outcomes, const Products& products) {
  return std::ranges::all_of(
      products.list, [&](Product product) { return outcomes.of(product) == doctor::Outcome::ok; });
}

std::string table(const doctor::Diagnosis& diagnosis, std::string_view title,
                  const Products& products) {
  auto width = std::max(kMinTitleWidth, title.size());
  for (const auto& check : diagnosis.checks())
    if (!is_good(check.outcomes, products)) width = std::max(width, check.title.size());
  auto out = fmt::format("{:<{}} ", title, width);
  for (const auto product : products.list)
    out += fmt::format("{:<{}}", doctor::id(product, products.lineup), kColumnWidth);
  out = out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
  // One line stands for all checks that are good for every product. The JSON has each of them.
  std::size_t good = 0;
  for (const auto& check : diagnosis.checks())
    if (is_good(check.outcomes, products))
      ++good;
    else
      out += row(check.title, check.outcomes, products, width);
  if (good > 0) out += row(count_text(good, "check"), {}, products, width);
  return out + row("in all", diagnosis.outcomes(), products, width);
}

// The findings about the chosen products.
std::vector<Finding> findings_for(const Products& products, const doctor::Diagnosis& diagnosis) {
  std::vector<Finding> out;
  for (const auto& check : diagnosis.checks())
    std::ranges::copy_if(check.findings, std::back_inserter(out),
                         [&](const Finding& finding) { return concerns(finding, products); });
  return out;
}

// A check and the chosen products.
struct ShownCheck {
  const doctor::Check* check;
  const Products* products;

  std::optional<std::string> fix() const {
    const auto said = std::ranges::find_if(
        check->findings, [&](const Finding& finding) { return concerns(finding, *products); });
    if (said == check->findings.end()) return std::nullopt;
    return said->hint.empty() ? std::string(info(check->rule).hint) : said->hint;
  }
  static constexpr auto fields() {
    using T = ShownCheck;
    return std::tuple(
        computed<T>("id", [](const T& one) { return info(one.check->rule).id; },
                    {.pattern = "^[A-Z]+[0-9]{3}$"}),
        computed<T>("title", [](const T& one) { return one.check->title; }),
        computed<T>("verdicts",
                    [](const T& one) { return verdicts_json(one.check->outcomes, *one.products); },
                    {.note = "by vendor: ok, unsafe, late, fail", .def = "outcomes"}),
        field<&T::fix>({.omits_empty = true}));
  }
};

// The diagnosis of one folder.
struct ShownDiagnosis {
  std::string title;
  doctor::Diagnosis diagnosis;
  Products products;

  std::vector<std::string> vendors() const {
    std::vector<std::string> out;
    for (const auto product : products.list) out.push_back(doctor::id(product, products.lineup));
    return out;
  }
  std::vector<ShownCheck> checks() const {
    std::vector<ShownCheck> out;
    for (const auto& check : diagnosis.checks()) out.push_back({&check, &products});
    return out;
  }
  static constexpr auto fields() {
    using T = ShownDiagnosis;
    return std::tuple(
        field<&T::vendors>(
            {.note = "with the version that is predicted: the named or the installed one",
             .def = "product",
             .min = 1}),
        field<&T::checks>(),
        computed<T>(
            "verdicts",
            [](const T& one) { return verdicts_json(one.diagnosis.outcomes(), one.products); },
            {.note = "of all checks", .def = "outcomes"}));
  }
  std::string text() const {
    return table(diagnosis, title, products) + counts_text(findings_for(products, diagnosis)) +
           '\n';
  }
};

// Adds the findings to the report and returns the diagnosis to show.
ShownDiagnosis shown_diagnosis(Report& report, const fs::path& folder, doctor::Diagnosis diagnosis,
                               const doctor::Settings& settings, const Products& products) {
  add_findings(report, findings_for(products, diagnosis), folder);
  if (!is_good(diagnosis.outcomes(), products)) report.exit = Exit::no;
  return {fmt::format("{}, domain {}", printable(folder.string()), settings.domain),
          std::move(diagnosis), products};
}

// A product of one participant and a product of the other one.
struct ProductMeeting {
  std::string self, peer;
  bool talk;
  std::string names;  // of both participants

  static constexpr auto fields() {
    using T = ProductMeeting;
    return std::tuple(field<&T::self>({.def = "product"}), field<&T::peer>({.def = "product"}),
                      field<&T::talk>());
  }
};

struct DiagnosedPeer {
  ShownDiagnosis diagnosis;
  std::vector<ProductMeeting> meetings = {};

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&DiagnosedPeer::diagnosis),
                          std::tuple(field<&DiagnosedPeer::meetings>()));
  }
  std::string text() const {
    auto out = diagnosis.text() + '\n';
    for (const auto& one : meetings)
      out += fmt::format("{}: {}\n", one.names, one.talk ? "they talk" : "they do NOT talk");
    return out;
  }
};

}  // namespace

template <>
struct FieldsOf<doctor::HostPlugin> {
  using T = doctor::HostPlugin;
  using Words = std::optional<std::string_view>;
  static Words if_any(std::string_view text) { return text.empty() ? Words() : text; }
  static constexpr auto fields() {
    return std::tuple(
        field<&T::role>({.words = "authentication|access control|cryptography"}),
        field<&T::library>(),
        computed<T>("file", [](const T& one) { return if_any(one.file.native()); }),
        computed<T>(
            "maker",
            [](const T& one) {
              using enum T::PluginProduct;
              return if_any(one.product == ddssec ? "ddssec" : one.product == other ? "other" : "");
            },
            {.note = "ddssec, other; null: not found", .words = "ddssec|other"}),
        computed<T>("version", [](const T& one) { return if_any(one.version); }));
  }
};

namespace {

struct DoctorResult {
  DomainId domain;
  ShownDiagnosis diagnosis;
  std::vector<doctor::HostPlugin> plugins = {};
  std::optional<DiagnosedPeer> peer = {};
  bool is_configured;  // true if the environment names the configuration

  static constexpr auto fields() {
    using T = DoctorResult;
    return std::tuple_cat(
        std::tuple(field<&T::domain>()), fields_within(&T::diagnosis),
        std::tuple(field<&T::plugins>(
                       {"what Cyclone DDS would load with this LD_LIBRARY_PATH; empty: nothing "
                        "is found, or no configuration is at hand"}),
                   field<&T::peer>(
                       {.note = "with --peer: the same of the other participant, and `meetings` "
                                "(each: `self`, `peer`, `talk`)",
                        .has_same_members = true,
                        .omits_empty = true})));
  }
  std::string text() const {
    auto out = diagnosis.text();
    if (!plugins.empty())
      out += fmt::format(
          "with this LD_LIBRARY_PATH{} Cyclone DDS would load\n",
          is_configured ? "" : ", and CYCLONEDDS_URI set to the folder's cyclonedds.xml,");
    for (const auto& plugin : plugins)
      out += fmt::format("  {:<15} {}{}{}\n", plugin.role, product_of(plugin),
                         plugin.file.empty() ? "" : ": " + plugin.file.string(),
                         plugin.missing.empty() ? ""
                                                : fmt::format(" (cannot be loaded without {})",
                                                              fmt::join(plugin.missing, ", ")));
    return peer ? out + '\n' + peer->text() : out;
  }
};

bool is_said_by_diagnosis(Rule rule) {
  constexpr Rule kSaid[] = {Rule::DOC008, Rule::DOC090, Rule::DOC091, Rule::DOC093,
                            Rule::DOC101, Rule::DOC102, Rule::DOC103};
  return std::ranges::find(kSaid, rule) != std::end(kSaid);
}

// Checks each product of one side with each product of the other. If two different products do not
// talk, the answer is "no" only if --vendor names the products.
std::vector<ProductMeeting> meetings_of(Report& report, const doctor::Party (&parties)[2],
                                        const doctor::Settings& settings, const Products& products,
                                        bool products_chosen) {
  const auto& [self, peer] = parties;
  std::vector<ProductMeeting> out;
  std::vector<std::string> said;
  const auto& lineup = products.lineup;
  for (const auto a : products.list)
    for (const auto b : products.list) {
      const MeetingView view{
          .meeting = predict_with_properties({self.folder, a, self.name, lineup},
                                             {peer.folder, b, peer.name, lineup}, settings),
          .names = {self.name, peer.name}};
      const auto& meeting = view.meeting;
      out.push_back({doctor::id(a, lineup), doctor::id(b, lineup), view.talk(),
                     fmt::format("{} on {}, {} on {}", self.name, doctor::id(a, lineup), peer.name,
                                 doctor::id(b, lineup))});
      if (!out.back().talk && (a == b || products_chosen)) report.exit = Exit::no;
      auto findings = meeting.findings;
      std::ranges::copy_if(meeting.notes, std::back_inserter(findings), [](const auto& note) {
        return note.rule == Rule::DOC094;  // the other notes are only about this pair
      });
      for (const auto& finding : findings) {
        if (is_said_by_diagnosis(finding.rule)) continue;
        if (std::ranges::find(said, finding.message) != said.end()) continue;
        said.push_back(finding.message);
        report.findings.push_back(finding);
      }
    }
  return out;
}

DiagnosedPeer peer_of(
    Report& report, const Arguments& arguments,
    const std::pair<const doctor::LoadedFolder&, const doctor::LoadedFolder&>& both,
    const doctor::Settings& settings, const Products& products) {
  const fs::path folders[] = {arguments.text("DIR"), arguments.text("--peer")};
  const auto& [self, peer] = both;
  auto diagnosis = diagnosis_of(peer, settings);
  doctor::diagnose_lint(peer, settings, diagnosis);
  DiagnosedPeer out{shown_diagnosis(report, folders[1], std::move(diagnosis), settings, products)};
  std::string names[2];
  name_parties(folders[0], folders[1], names);
  out.meetings =
      meetings_of(report, {{self, Product::ddssec, names[0]}, {peer, Product::ddssec, names[1]}},
                  settings, products, arguments.has("--vendor"));
  return out;
}

// A ROS 2 node uses only its environment, and runs in domain 0 if the environment names none.
Result<DomainId> ros_domain() {
  const auto environment = doctor::ros_environment();
  const auto found = environment.find("ROS_DOMAIN_ID");
  if (found == environment.end() || found->second.empty()) return DomainId{0};
  if (const auto domain = doctor::node_domain(found->second)) return *domain;
  return fail(Code::usage,
              {.field = "the environment variable ROS_DOMAIN_ID",
               .expected = fmt::format("a number from 0 to {}", governance::kMaxGovernedDomainId),
               .found = '"' + found->second + '"',
               .note = "a leading 0 makes it octal for a node, 0x hexadecimal"});
}

std::vector<doctor::HostPlugin> host_plugins_for(const fs::path& folder, bool is_of_ros,
                                                 const doctor::LoaderPlaces& places) {
  if (is_of_ros) return plugins_of_node(places);
  const auto configuration = configuration_for(folder);
  return configuration ? doctor::host_plugins(*configuration, places)
                       : std::vector<doctor::HostPlugin>();
}

// False on a machine without Cyclone DDS, which has no plugins to report.
bool is_any_found(const std::vector<doctor::HostPlugin>& plugins) {
  return std::ranges::any_of(plugins, [](const auto& plugin) {
    return !plugin.file.empty() || plugin.library.contains('/');
  });
}

void append(std::vector<fs::path>& out, std::vector<fs::path> more) {
  std::ranges::move(more, std::back_inserter(out));
}

// The files that a Cyclone DDS process of the participant reads, in the folder or elsewhere.
std::vector<fs::path> files_of_process(const fs::path& folder, DomainId domain,
                                       const std::vector<doctor::HostPlugin>& plugins) {
  using Place = doctor::ConfigurationPlace;
  std::vector<fs::path> out;
  for (const auto& plugin : plugins)
    if (!plugin.file.empty()) out.push_back(plugin.file);
  const char* const properties = std::getenv(spi::kPropertiesVariable);
  if (properties != nullptr && *properties != '\0') out.emplace_back(properties);
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  const bool is_named = uri != nullptr && *uri != '\0';
  if (is_named) append(out, doctor::files_named_by(uri));
  if (const auto text = configuration_for(folder)) {
    const auto place = is_named ? Place::variable : Place::file;
    const auto inline_from = is_named ? text->size() - doctor::inline_octets(uri) : 0;
    const auto security = doctor::effective_security(*text, domain, place, inline_from);
    append(out, doctor::paths_of(doctor::named_by_cyclonedds(*text, security, domain)));
  }
  return out;
}

// Returns the domain of the node. If the documents do not cover it, returns one that they cover:
// otherwise the wrong variable (DOC096) would be reported again for each document.
Result<DomainId> domain_of_node(const doctor::LoadedFolder& folder, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto domain, ros_domain());
  const auto named = doctor::domains_of(folder, now);
  if (named.empty() || doctor::contains(named, domain)) return domain;
  const doctor::Domains participants[] = {named};
  return doctor::choose_domain(participants).domain;
}

Result<Answer<DoctorResult>> doctor_of(const Arguments& arguments, const Context& context) {
  const fs::path folder = arguments.text("DIR");
  Report report;
  DDSSEC_ASSIGN_OR_RETURN(const auto products, products_of(arguments, report));
  const auto now = context.clock.calendar_seconds();
  DDSSEC_RETURN_IF_ERROR(check_participant_folder(folder));
  const auto loaded = load_participant(folder, now);
  std::optional<doctor::LoadedFolder> peer;
  if (arguments.has("--peer")) {
    DDSSEC_RETURN_IF_ERROR(check_participant_folder(arguments.text("--peer")));
    peer = load_participant(arguments.text("--peer"), now);
  }
  const bool is_of_ros = arguments.has("--ros") && !arguments.has("--domain");
  DDSSEC_ASSIGN_OR_RETURN(
      const auto domain,
      is_of_ros ? domain_of_node(loaded, now)
                : domain_for(arguments, {&loaded, peer ? &*peer : &loaded}, now, report));
  const doctor::Settings settings{.now = now, .domain = domain, .lineup = products.lineup};
  auto diagnosis = diagnosis_of(loaded, settings);
  if (arguments.has("--ros"))
    doctor::diagnose_ros(loaded, doctor::ros_environment(), settings, diagnosis);
  if (arguments.has("--plugins"))
    doctor::diagnose_plugins(
        arguments.text("--plugins") == "system" ? "" : arguments.text("--plugins"), diagnosis);
  if (!arguments.has("--ros")) warn_of_unset_variable(loaded, settings, diagnosis);
  if (!arguments.has("--ros") && arguments.has("--vendor"))
    warn_of_unset_profiles_file(loaded, settings, diagnosis);
  const auto in_force = doctor::cyclonedds_configuration();
  doctor::diagnose_shared_memory(loaded, in_force, settings, diagnosis);
  doctor::diagnose_transport(in_force, diagnosis);
  const auto places = doctor::LoaderPlaces::here();
  const auto plugins = host_plugins_for(folder, arguments.has("--ros"), places);
  if (arguments.has("--ros"))
    doctor::diagnose_loadable(plugins, diagnosis);
  else
    doctor::diagnose_host_plugins(plugins, places, path_exists(folder / "cyclonedds.xml"),
                                  diagnosis);
  doctor::diagnose_files_of_process(loaded, files_of_process(folder, domain, plugins), diagnosis);
  doctor::diagnose_lint(loaded, settings, diagnosis);
  DoctorResult result{
      .domain = domain,
      .diagnosis = shown_diagnosis(report, folder, std::move(diagnosis), settings, products),
      .is_configured = in_force || arguments.has("--ros")};
  if (is_any_found(plugins)) result.plugins = plugins;
  if (peer) result.peer = peer_of(report, arguments, {loaded, *peer}, settings, products);
  return Answer<DoctorResult>{std::move(result), std::move(report)};
}

}  // namespace

doctor::LoadedFolder load_participant(const fs::path& folder, WallTime now) {
  auto out = doctor::load_folder(pki::participant_folder(folder), now);
  open_key(out);
  return out;
}

Result<DomainId> domain_for(const Arguments& arguments,
                            std::initializer_list<const doctor::LoadedFolder*> folders,
                            WallTime now, Report& report) {
  if (arguments.has("--domain")) return domain_of(arguments);
  std::vector<doctor::Domains> domains;
  for (const auto* folder : folders) domains.push_back(domains_of(*folder, now));
  const auto choice = doctor::choose_domain(domains);
  if (choice.has_others())
    report.findings.push_back(
        {.rule = Rule::DOC095,
         .message = fmt::format("the documents are for domains {}; domain {} was checked",
                                doctor::to_text(choice.named), choice.domain)});
  return choice.domain;
}

void name_parties(const fs::path& a, const fs::path& b, std::string (&names)[2]) {
  names[0] = printable(folder_name(a));
  names[1] = printable(folder_name(b));
  if (names[0] != names[1]) return;
  names[0] = printable(a.string());
  names[1] = printable(b.string());
}

std::vector<Command> doctor_commands() {
  return {
      {.group = "",
       .name = "doctor",
       .summary = "Finds what is wrong with a participant's folder, for each product; exit 1 if "
                  "something is.",
       .positionals = {{"DIR", "the participant's folder, flat or an enclave of sros2"}},
       .options = {kDomainToCheck,
                   repeated("--vendor", "V",
                            "all, cyclonedds, fastdds or ddssec; with @VERSION if another than "
                            "the installed one matters"),
                   {"--peer", "DIR", "another participant: would they talk?"},
                   {"--ros", "", "as an enclave of ROS 2, with its variables and ROS_DOMAIN_ID"},
                   {"--plugins", "WHERE",
                    "load the plugin libraries of this folder, or (system) Cyclone DDS's"}},
       .examples = {"ddssec doctor demo/talker", "ddssec doctor talker --vendor fastdds@3.1.2",
                    "ddssec doctor talker --peer listener"},
       .run = doctor_of,
       .instead_of_extra = "ddssec check compares two participants"}};
}

}  // namespace ddssec::cli
