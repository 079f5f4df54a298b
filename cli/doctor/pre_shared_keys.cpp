#include "cli/doctor/pre_shared_keys.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/doctor/ocsp_checks.hpp"
#include "cli/doctor/participant_diagnosis.hpp"
#include "plugins/cryptography/passphrase.hpp"
#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"
#include "plugins/spi/symmetric_cipher.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
namespace property = spi::property;
using cryptography::Passphrase;
using doctor::LoadedFolder;
using doctor::Outcome;

// The passphrases from a folder's properties, and the warnings about them.
struct PreSharedKeys final : EventSink {
  std::vector<Passphrase> passphrases;
  std::string cipher;
  std::vector<Error> warnings;
  void raise(const Event& event) override { warnings.push_back(event.error); }

  std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> out;
    for (const auto& passphrase : passphrases) out.push_back(passphrase.id);
    return out;
  }
};

// The protection kind that the governance document demands. NONE means that there are no pre-shared
// keys.
ProtectionKind required_protection(const LoadedFolder& folder, DomainId domain) {
  if (!folder.governance.model) return ProtectionKind::none;
  const auto* const rule = folder.governance.model->find(domain);
  return rule == nullptr ? ProtectionKind::none : rule->rtps_psk_protection_kind;
}

Result<PreSharedKeys> keys_of(const LoadedFolder& folder) {
  PreSharedKeys out;
  std::error_code ignored;
  spi::PropertyList properties;
  if (std::filesystem::exists(folder.paths.properties, ignored)) {
    DDSSEC_ASSIGN_OR_RETURN(properties, spi::read_property_file(folder.paths.properties));
  }
  DDSSEC_ASSIGN_OR_RETURN(out.passphrases, cryptography::PassphraseFiles(properties, {}).load(out));
  const auto* const cipher = spi::find_property(properties, property::kPskCipher);
  out.cipher = cipher == nullptr || *cipher == "AUTO" ? std::string(spi::kAes256Name) : *cipher;
  return out;
}

Finding missing(const LoadedFolder& folder, ProtectionKind kind, const Error& error) {
  const auto& place = error.details().document;
  return {.rule = Rule::DOC091,
          .message = fmt::format("<rtps_psk_protection_kind> is {}, and {}: {}", to_string(kind),
                                 place.empty() ? "the properties" : place, error.message()),
          .document = folder.paths.properties.string(),
          .line = error.details().line};
}

// The reason why `to` cannot decrypt the messages of `from`; empty if it can.
std::string obstacle(const doctor::Party& from, const PreSharedKeys& of_from,
                     const doctor::Party& to, const PreSharedKeys& of_to) {
  const auto& sends = of_from.passphrases.front();
  const auto known = std::ranges::find(of_to.passphrases, sends.id, &Passphrase::id);
  if (known == of_to.passphrases.end())
    return fmt::format("{} sends under passphrase {}, and {} understands {} only", from.name,
                       sends.id, to.name, fmt::join(of_to.ids(), ", "));
  if (known->text != sends.text)
    return fmt::format("{} and {} have different passphrases under id {}", from.name, to.name,
                       sends.id);
  if (of_from.cipher != of_to.cipher)
    return fmt::format("pre-shared keys are for {} at {} and for {} at {}", of_from.cipher,
                       from.name, of_to.cipher, to.name);
  return {};
}

void add_once(std::vector<Finding>& findings, Finding finding) {
  const auto same = [&](const Finding& said) { return said.message == finding.message; };
  if (std::ranges::none_of(findings, same)) findings.push_back(std::move(finding));
}

void refuse(doctor::Meeting& out, Finding finding) {
  out.properties_fit = false;
  add_once(out.findings, std::move(finding));
}

void compare(const doctor::Party& a, const doctor::Party& b, DomainId domain,
             doctor::Meeting& out) {
  const auto kind = required_protection(a.folder, domain);
  const auto of_a = keys_of(a.folder), of_b = keys_of(b.folder);
  if (!of_a) refuse(out, missing(a.folder, kind, of_a.error()));
  if (!of_b) refuse(out, missing(b.folder, kind, of_b.error()));
  if (!of_a || !of_b) return;
  for (const auto& why : {obstacle(a, *of_a, b, *of_b), obstacle(b, *of_b, a, *of_a)})
    if (!why.empty())
      refuse(
          out,
          {.rule = Rule::DOC092, .message = why, .document = b.folder.paths.properties.string()});
}

// Adds refusals that predict_meeting() cannot know of, because they come from the environment and
// the properties. Missing passphrases are compared below.
void refuse_beyond_folder(const doctor::Party& party, const doctor::Settings& settings,
                          doctor::Meeting& out) {
  const auto diagnosis = diagnosis_beyond_folder(party.folder, settings);
  for (const auto& check : diagnosis.checks()) {
    const bool is_compared = check.rule == Rule::DOC091;
    if (is_compared || check.outcomes.of(party.product) != Outcome::fail) continue;
    for (const auto& finding : check.findings)
      if (finding.severity == Severity::error) refuse(out, finding);
  }
}

// Reports topics for which a participant with the drop-in plugins refuses to create its writer or
// reader.
void refuse_topics(const doctor::Party& a, const doctor::Party& b, doctor::Meeting& out) {
  const doctor::Party* const parties[] = {&a, &b};
  for (int i = 0; i < 2; ++i) {
    const auto& party = *parties[i];
    if (party.product != doctor::Product::ddssec || !runs_drop_in(party.folder)) continue;
    for (auto& topic : out.topics) {
      if (topic.rules[i] == nullptr || out.rules[i] == nullptr) continue;
      for (auto& direction : topic.directions) {
        const auto action =
            direction.writer == i ? governance::Action::publish : governance::Action::subscribe;
        auto finding = refused_by_drop_in(party.folder, *out.rules[i], *topic.rules[i], action);
        if (!finding || !direction.obstacle.reason.empty()) continue;
        direction.ok = false;
        direction.obstacle = {fmt::format("{}: {}", party.name, finding->message), finding->rule,
                              finding->document, finding->line};
        finding->message = direction.obstacle.reason;
        add_once(out.findings, std::move(*finding));
      }
    }
  }
}

}  // namespace

void diagnose_pre_shared_keys(const LoadedFolder& folder, const doctor::Settings& settings,
                              doctor::Diagnosis& out) {
  const auto kind = required_protection(folder, settings.domain);
  if (!is_protected(kind)) return;
  out.pass(Rule::DOC091);
  const auto keys = keys_of(folder);
  if (!keys) return out.report({.ddssec = Outcome::fail}, missing(folder, kind, keys.error()));
  for (const auto& warning : keys->warnings)
    out.report({}, {.rule = Rule::DOC091,
                    .message = warning.message(),
                    .document = folder.paths.properties.string(),
                    .severity = Severity::warning});
}

doctor::Meeting predict_with_properties(const doctor::Party& a, const doctor::Party& b,
                                        const doctor::Settings& settings,
                                        const std::vector<std::string>& topics) {
  auto out = doctor::predict_meeting(a, b, settings, topics);
  for (const auto* party : {&a, &b}) refuse_beyond_folder(*party, settings, out);
  refuse_topics(a, b, out);
  for (auto& finding : demanded_responses(a, b, settings.now)) refuse(out, std::move(finding));
  const auto needs_keys = [&](const doctor::Party& party) {
    return party.product == doctor::Product::ddssec &&
           is_protected(required_protection(party.folder, settings.domain));
  };
  if (needs_keys(a) && needs_keys(b)) compare(a, b, settings.domain, out);
  return out;
}

}  // namespace ddssec::cli
