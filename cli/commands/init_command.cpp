// init: creates everything for two participants that communicate, in one command.
#include <filesystem>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/certificate_facts.hpp"
#include "cli/ca/governance_revision.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/enclaves.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/frame/options.hpp"
#include "cli/frame/progress.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/participant_options.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/configuration_files.hpp"
#include "cli/participant/drop_in.hpp"
#include "cli/participant/keystore.hpp"
#include "cli/participant/participant.hpp"
#include "governance/profile.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The plan that the command line describes.
struct Plan {
  fs::path target;
  std::string title;  // part of the CAs' names
  std::vector<std::string> names;
  pki::FolderLayout layout;
  governance::Profile profile;
  std::vector<governance::DomainRange> domains;
  std::vector<std::string> topics;
  pki::Validity ca_life;
  pki::Validity life;
  fs::path dropin;
};

Result<pki::FolderLayout> layout_of(const Arguments& arguments) {
  const auto word = arguments.text("--layout");
  if (word == "flat") return pki::FolderLayout::flat;
  if (word == "sros2") return pki::FolderLayout::sros2;
  return fail(Code::usage, {.field = "--layout", .expected = "flat or sros2", .found = word});
}

// The names in a keystore are names of enclaves, which begin with a slash.
Result<std::vector<std::string>> names_of(const Arguments& arguments, pki::FolderLayout layout) {
  auto names = arguments.all("--participant");
  if (names.empty()) names = {"talker", "listener"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    auto& name = names[i];
    if (layout == pki::FolderLayout::sros2) {
      if (!name.starts_with('/')) name = std::string("/").append(name);
      DDSSEC_RETURN_IF_ERROR(check_enclave(name));
    } else {
      DDSSEC_RETURN_IF_ERROR(
          check_name(name, "ddssec identity issue --subject gives a certificate any other name"));
      if (name == "ca")
        return fail(Code::name_unusable, {.found = name,
                                          .note = "the CAs' folder has this name",
                                          .hint = "choose another name for the participant"});
    }
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), name) !=
        names.begin() + static_cast<std::ptrdiff_t>(i))
      return fail(Code::usage,
                  {.field = "--participant", .note = "\"" + name + "\" is given twice"});
  }
  return names;
}

Result<Plan> plan_of(const Arguments& arguments, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto layout, layout_of(arguments));
  const fs::path target = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(auto names, names_of(arguments, layout));
  DDSSEC_ASSIGN_OR_RETURN(const auto profile, profile_option(arguments));
  DDSSEC_ASSIGN_OR_RETURN(auto domains, domain_ranges(arguments, "--domain"));
  DDSSEC_ASSIGN_OR_RETURN(auto topics, topics_of(arguments, "--allow-topics"));
  DDSSEC_ASSIGN_OR_RETURN(const auto life, validity(arguments, now));
  DDSSEC_ASSIGN_OR_RETURN(auto dropin, drop_in_of(arguments));
  if (layout == pki::FolderLayout::sros2 && !dropin.empty())
    return fail(Code::usage, {.field = "--dropin",
                              .note = "not with --layout sros2: ROS 2 names the libraries itself",
                              .hint = "let LD_LIBRARY_PATH begin with that folder"});
  return Plan{.target = target,
              .title = folder_name(target),
              .names = std::move(names),
              .layout = layout,
              .profile = profile,
              .domains = std::move(domains),
              .topics = std::move(topics),
              .ca_life = validity_of(3650, now),
              .life = life,
              .dropin = std::move(dropin)};
}

Result<OpenCa> make_ca(const Plan& plan, std::string_view role, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto authority,
      pki::Authority::create_root(ca_subject(plan.title, role), {}, plan.ca_life, context.random));
  auto pem = authority.certificate().pem();
  return OpenCa{{}, std::move(authority), std::move(pem)};
}

struct FirstParticipant {
  std::string name;
  fs::path dir;
  std::string subject;
  WallTime not_after;

  static constexpr auto fields() {
    using Self = FirstParticipant;
    return std::tuple(field<&Self::name>(), field<&Self::dir>(),
                      field<&Self::subject>({.def = "subject"}), field<&Self::not_after>());
  }
};

// The lines that configurations need.
struct Snippets {
  std::string cyclonedds, fastdds;
  std::optional<std::string> ros2 = {};

  static constexpr auto fields() {
    return std::tuple(field<&Snippets::cyclonedds>(), field<&Snippets::fastdds>(),
                      field<&Snippets::ros2>({.note = "sros2 only", .omits_empty = true}));
  }
};

struct InitResult {
  fs::path dir;
  std::vector<NewCaFacts> cas;
  std::string profile;
  std::vector<FirstParticipant> participants;
  Snippets snippets;
  std::string domains, topics;  // in words

  static constexpr auto fields() {
    using Self = InitResult;
    return std::tuple(field<&Self::dir>(), field<&Self::cas>({.min = 2, .max = 2}),
                      field<&Self::profile>({.words = "open|balanced|strict"}),
                      field<&Self::participants>({.min = 1}),
                      field<&Self::snippets>({"of the first participant"}));
  }
  std::string text() const {
    auto out =
        fmt::format("created {}  (to try things: the CA keys are NOT encrypted)\n", dir.string());
    for (const auto& ca : cas)
      out += fmt::format("  {:<15} {}  expires {}  sha256 {}\n", ca.role + " CA", ca.subject,
                         date(ca.not_after), ca.sha256);
    out += fmt::format("  {:<15} domain {}, profile {}\n", "governance", domains, profile);
    for (const auto& one : participants)
      out += fmt::format("  {:<15} {}  publish and subscribe {}  expires {}\n", one.name,
                         one.subject, topics, date(one.not_after));
    return out;
  }
};

// The participants of the new folder.
struct Members {
  std::vector<FirstParticipant> rows = {};
  std::string log = {};         // for the identity CA
  std::string signed_log = {};  // for the permissions CA
};

Result<Members> add_members(NewFolder& folder, const Plan& plan, const Issuers& issuers,
                            BytesView governance, const Context& context) {
  Members out;
  Progress progress("participants", plan.names.size());
  const bool sros2 = plan.layout == pki::FolderLayout::sros2;
  const auto now = context.clock.calendar_seconds();
  for (const auto& name : plan.names) {
    const ParticipantSpec spec{.name = name,
                               .subject = "CN=" + name,
                               .life = plan.life,
                               .domains = plan.domains,
                               .publish = plan.topics,
                               .subscribe = plan.topics,
                               .partitions = {"*"},
                               .dropin = plan.dropin};
    DDSSEC_ASSIGN_OR_RETURN(const auto made, make_participant(spec, issuers, context));
    const auto below = sros2 ? enclave_folder(name) : fs::path(name);
    DDSSEC_RETURN_IF_ERROR(sros2 ? add_enclave(folder, below, name, made)
                                 : add_flat(folder, below, made, issuers, governance));
    if (sros2) DDSSEC_RETURN_IF_ERROR(folder.add_public(below / "crl.pem", issuers.crl));
    out.log += log_line(made, plan.target / below, now);
    out.signed_log += signed_line(made, *issuers.permissions, plan.target / below, now);
    const auto& certificate = made.self.certificate;
    out.rows.push_back({name, plan.target / below, certificate.subject(), certificate.not_after()});
    progress.step();
  }
  return out;
}

Status add_cas(NewFolder& folder, const Plan& plan, const OpenCa& identity,
               const OpenCa& permissions, const pki::Crl& crl) {
  if (plan.layout == pki::FolderLayout::sros2) {
    DDSSEC_RETURN_IF_ERROR(
        add_keystore_cas(folder, identity.authority, &permissions.authority, nullptr));
    return folder.add_public("public/identity_ca.crl.pem", crl.pem());
  }
  DDSSEC_RETURN_IF_ERROR(add_ca(folder, ca_paths_in("ca/identity"), identity.trust_pem,
                                {identity.authority.key()}, nullptr));
  DDSSEC_RETURN_IF_ERROR(add_ca(folder, ca_paths_in("ca/permissions"), permissions.trust_pem,
                                {permissions.authority.key()}, nullptr));
  return folder.add_public("ca/identity/crl.pem", crl.pem());
}

std::string domain_words(const std::vector<governance::DomainRange>& domains) {
  std::string out;
  for (const auto& range : domains)
    out += (out.empty() ? "" : ", ") + (range.first == range.last
                                            ? fmt::format("{}", range.first)
                                            : fmt::format("{}-{}", range.first, range.last));
  return out;
}

Snippets snippets_of(const Plan& plan) {
  const bool sros2 = plan.layout == pki::FolderLayout::sros2;
  const auto& first = plan.names.front();
  const auto files = pki::participant_folder(
      plan.target / (sros2 ? enclave_folder(first) : fs::path(first)), plan.layout);
  Snippets out{cyclonedds_snippet(files, plan.dropin), fastdds_snippet(files)};
  if (sros2) out.ros2 = ros2_snippet(plan.target, first, plan.domains);
  return out;
}

std::string next_steps(const Plan& plan, const Snippets& snippets) {
  const auto& first = plan.names.front();
  const bool sros2 = plan.layout == pki::FolderLayout::sros2;
  const auto folder = plan.target / (sros2 ? enclave_folder(first) : fs::path(first));
  const auto out = fmt::format("next: ddssec doctor {}\n", shell_word(folder.string()));
  if (sros2) return out + fmt::format("\n{} with ROS 2:\n{}", first, snippets.ros2.value_or(""));
  return out + configuration_lines(first, folder) +
         "each participant's folder has these two files; they name it by its whole path\n" +
         drop_in_line(plan.dropin);
}

Result<Answer<InitResult>> init(const Arguments& arguments, const Context& context) {
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto plan, plan_of(arguments, now));
  DDSSEC_RETURN_IF_ERROR(check_nameable(plan.target));
  DDSSEC_ASSIGN_OR_RETURN(auto folder, NewFolder::at(plan.target));
  DDSSEC_ASSIGN_OR_RETURN(const auto identity, make_ca(plan, "Identity", context));
  DDSSEC_ASSIGN_OR_RETURN(const auto permissions, make_ca(plan, "Permissions", context));
  DDSSEC_ASSIGN_OR_RETURN(const auto crl, first_crl(identity.authority));
  const auto list = crl.pem();
  const Issuers issuers{identity, &permissions, list, permissions.trust_pem};
  DDSSEC_RETURN_IF_ERROR(add_cas(folder, plan, identity, permissions, crl));

  const auto xml = to_xml(governance::governance_of(plan.profile, plan.domains));
  const auto text = with_first_revision(xml);
  DDSSEC_ASSIGN_OR_RETURN(const auto governance,
                          permissions.authority.sign_document(text.octets, now, context.random));
  const bool sros2 = plan.layout == pki::FolderLayout::sros2;
  if (sros2) {
    DDSSEC_RETURN_IF_ERROR(add_keystore_governance(folder, xml, governance));
  } else {
    DDSSEC_RETURN_IF_ERROR(folder.add_public("governance.xml", xml));
    DDSSEC_RETURN_IF_ERROR(folder.add("governance.p7s", governance, 0644));
  }
  DDSSEC_ASSIGN_OR_RETURN(auto members, add_members(folder, plan, issuers, governance, context));
  const auto document = plan.target / (sros2 ? "enclaves/governance.p7s" : "governance.p7s");
  DDSSEC_RETURN_IF_ERROR(folder.add_public(
      sros2 ? "private/permissions_ca.signed.jsonl" : "ca/permissions/signed.jsonl",
      signed_line(permissions.certificate(), text, document, now) + members.signed_log));
  DDSSEC_RETURN_IF_ERROR(folder.add_public(
      sros2 ? "private/identity_ca.issued.jsonl" : "ca/identity/issued.jsonl", members.log));

  Answer<InitResult> out{{.dir = plan.target,
                          .cas = {NewCaFacts::of("identity", identity.certificate()),
                                  NewCaFacts::of("permissions", permissions.certificate())},
                          .profile = std::string(to_string(plan.profile)),
                          .participants = std::move(members.rows),
                          .snippets = snippets_of(plan),
                          .domains = domain_words(plan.domains),
                          .topics = fmt::format("{}", fmt::join(plan.topics, " "))}};
  out.report.text = next_steps(plan, out.result.snippets);
  DDSSEC_ASSIGN_OR_RETURN(out.report.files_written, folder.commit());
  return out;
}

}  // namespace

std::vector<Command> init_commands() {
  return {{.group = "",
           .name = "init",
           .summary = "Makes everything for a first try: CAs, governance, participants.",
           .positionals = {{"DIR", "a new folder"}},
           .options = {repeated("--participant", "NAME",
                                "a participant; without any, talker and listener"),
                       kDomains,
                       {"--profile", "NAME", "open, balanced or strict", "strict"},
                       {"--layout", "NAME", "flat, or sros2: a keystore of ROS 2", "flat"},
                       {.name = "--allow-topics",
                        .value = "TOPIC",
                        .summary = "what each participant may publish and subscribe to",
                        .fallback = "*",
                        .repeated = true},
                       days("365"),
                       kDropIn},
           .examples = {"ddssec init demo",
                        "ddssec init demo --participant talker --participant "
                        "listener --domain 0",
                        "ddssec init keystore --layout sros2 --participant /talker"},
           .run = init}};
}

}  // namespace ddssec::cli
