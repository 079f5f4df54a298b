// Checks the participant's rights in the domain, and what expires first.
#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "base/text.hpp"
#include "governance/cyclonedds_subject.hpp"
#include "governance/date_time.hpp"
#include "governance/decision.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/doctor/product_decision.hpp"
#include "governance/doctor/subject_form.hpp"
#include "governance/grant.hpp"
#include "governance/topic_sets.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// Time zones range from UTC-12 to UTC+14.
constexpr auto kFarthestZone = 14h;
constexpr auto kSoon = std::chrono::hours(30 * 24);

// The input of the checks in this file.
struct Scene {
  const LoadedFolder& folder;
  const Settings& settings;
  Diagnosis& out;

  const Permissions& permissions() const { return *folder.permissions.model; }
  const fs::path& file() const { return folder.paths.permissions; }
};

// A grant, and the products that apply it to this participant.
struct Candidate {
  const Grant* grant;
  Outcomes subject;
};

std::vector<Candidate> candidates(const Permissions& permissions,
                                  const pki::Certificate& certificate, const Lineup& lineup) {
  std::vector<Candidate> out;
  const auto subject = pki::SubjectName::of(certificate);
  for (const auto& grant : permissions.grants) {
    auto outcomes = reads_subject(grant.subject_name, certificate, lineup);
    if (is_for(grant, subject)) outcomes.ddssec = Outcome::ok;
    if (grant.subject_has_line_breaks) outcomes.fastdds = Outcome::fail;
    if (outcomes != kAllFail) out.push_back({&grant, outcomes});
  }
  return out;
}

// The grant whose subject is written most like the certificate's.
const Grant* nearest(const Permissions& permissions, const std::string& subject) {
  constexpr std::size_t kMaxCompared = 1000, kMaxOctets = 256;
  const Grant* best = nullptr;
  auto least = std::numeric_limits<std::size_t>::max();
  for (std::size_t i = 0; i < std::min(permissions.grants.size(), kMaxCompared); ++i) {
    const auto& grant = permissions.grants[i];
    const auto distance =
        edit_distance(grant.subject_name.substr(0, kMaxOctets), subject.substr(0, kMaxOctets));
    if (distance < least) best = &grant, least = distance;
  }
  return best;
}

void report_no_grant(const Scene& scene) {
  const auto& subject = scene.folder.certificate->subject();
  const auto* grant = nearest(scene.permissions(), subject);
  scene.out.report(kAllFail,
                   {.rule = Rule::DOC010,
                    .message = fmt::format(
                        "no grant in {} is for \"{}\", the subject of {}; the grant that comes "
                        "nearest has <subject_name>{}</subject_name>",
                        scene.file().filename().string(), subject,
                        scene.folder.paths.certificate.filename().string(),
                        grant != nullptr ? grant->subject_name.substr(0, 256) : ""),
                    .document = scene.file(),
                    .line = grant != nullptr ? grant->line : 0,
                    .hint = remedy_of_ros(scene.folder)});
}

// The subject as a grant must write it.
struct Spelling {
  std::string text;
  std::string hint;  // empty if the rule's own hint fits
};

Spelling spelling_for(const pki::Certificate& certificate, const Lineup& lineup) {
  const auto& escaped = certificate.subject();
  const auto in_utf8 = pki::subject_in_utf8(certificate);
  if (escaped == in_utf8) return {'"' + escaped + '"', {}};
  return {
      fmt::format("\"{}\" for {} and \"{}\" for {}: with letters beyond ASCII no text is right "
                  "for both",
                  escaped, name(Product::cyclonedds, lineup), in_utf8,
                  name(Product::fastdds, lineup)),
      "issue the participant with a name in ASCII letters, or sign permissions with a grant for "
      "each of the two texts"};
}

void diagnose_form(const Scene& scene, const std::vector<Candidate>& all) {
  Outcomes best = kAllFail;
  for (const auto& one : all)
    for (auto member : {&Outcomes::cyclonedds, &Outcomes::fastdds, &Outcomes::ddssec})
      best.*member = std::min(best.*member, one.subject.*member);
  scene.out.pass(Rule::DOC010);
  if (best.all_ok()) return scene.out.pass(Rule::DOC011);
  const auto* grant = all.front().grant;
  const auto spelling = spelling_for(*scene.folder.certificate, scene.settings.lineup);
  scene.out.report(
      best,
      {.rule = Rule::DOC011,
       .message = fmt::format(
           "the grant says \"{}\"{}; it must say {}", grant->subject_name.substr(0, 256),
           grant->subject_has_line_breaks ? " between line breaks or tabs" : "", spelling.text),
       .document = scene.file(),
       .line = grant->line,
       .hint = spelling.hint});
}

constexpr std::string_view kHintOfZones = "write both dates of the grant in UTC, with a Z";

// Reports that Fast DDS applies a grant now and the other products do not, or the reverse.
void diagnose_fastdds_zones(const Scene& scene, const std::vector<Candidate>& all) {
  const auto now = scene.settings.now;
  const auto is_valid = [&](Product product) {
    return std::ranges::any_of(all, [&](const Candidate& one) {
      return validity_as(product, one.grant->validity).contains(now);
    });
  };
  const bool is_valid_for_fastdds = is_valid(Product::fastdds);
  if (is_valid_for_fastdds == is_valid(Product::ddssec)) return;
  const auto& grant = *all.front().grant;
  scene.out.report({.fastdds = is_valid_for_fastdds ? Outcome::unsafe : Outcome::fail},
                   {.rule = Rule::DOC042,
                    .message = fmt::format(
                        "grant \"{}\": {} ignores the zones of the dates, and so {} it now, {}",
                        grant.name, name(Product::fastdds, scene.settings.lineup),
                        is_valid_for_fastdds ? "takes" : "does not take", to_string(now)),
                    .document = scene.file(),
                    .line = grant.line,
                    .hint = std::string(kHintOfZones),
                    .severity = Severity::error});
}

void diagnose_cyclones_end(const Scene& scene, const Grant& grant) {
  if (grant.validity.is_read_alike_by_cyclonedds) return scene.out.pass(Rule::DOC040);
  scene.out.report(
      {.cyclonedds = Outcome::fail},
      {.rule = Rule::DOC040,
       .message = fmt::format("grant \"{}\": {} {}", grant.name,
                              name(Product::cyclonedds, scene.settings.lineup), kEndReadAsPast),
       .document = scene.file(),
       .line = grant.line,
       .hint = std::string(kEndReadAsPastHint)});
}

// Cyclone DDS uses only the first grant of the subject, the other products the first valid one.
void diagnose_grant_dates(const Scene& scene, const std::vector<Candidate>& all) {
  const auto now = scene.settings.now;
  const bool any = std::ranges::any_of(
      all, [&](const Candidate& one) { return one.grant->validity.contains(now); });
  const auto* first = all.front().grant;
  if (first->validity.contains(now)) return diagnose_cyclones_end(scene, *first);
  const bool early = now < first->validity.not_before;
  auto outcomes = any ? measured(Variant::grant_second, scene.settings.lineup) : kAllFail;
  if (validity_as(Product::fastdds, first->validity).contains(now)) outcomes.fastdds = Outcome::ok;
  scene.out.report(
      outcomes, {.rule = Rule::DOC040,
                 .message = fmt::format(
                     "grant \"{}\" of {}: <{}> is {}, now it is {}{}", first->name,
                     first->subject_name.substr(0, 256), early ? "not_before" : "not_after",
                     to_string(early ? first->validity.not_before : first->validity.not_after),
                     to_string(now),
                     any ? "; a later grant is valid, but Cyclone DDS reads the first only" : ""),
                 .document = scene.file(),
                 .line = first->line,
                 .hint = hint_if_early(first->validity.not_before, now)});
}

void diagnose_local_time(const Scene& scene, const Grant& grant) {
  const auto now = scene.settings.now;
  const auto is_near = [&](WallTime time) {
    return time - kFarthestZone < now && now < time + kFarthestZone;
  };
  const auto read = validity_as(Product::fastdds, grant.validity);
  const bool starts = is_near(read.not_before);
  if (!starts && !is_near(read.not_after)) return scene.out.pass(Rule::DOC042);
  scene.out.report(
      {}, {.rule = Rule::DOC042,
           .message =
               fmt::format("grant \"{}\": <{}> {} is so near to now, {}, that it depends on the "
                           "machine's time zone whether Fast DDS takes the grant",
                           grant.name, starts ? "not_before" : "not_after",
                           to_string(starts ? grant.validity.not_before : grant.validity.not_after),
                           to_string(now)),
           .document = scene.file(),
           .line = grant.line});
}

// Cyclone DDS applies the first grant that has all attributes of the certificate.
void diagnose_cyclones_grant(const Scene& scene, const std::vector<Candidate>& all) {
  const auto taken = std::ranges::find(
      all,
      GrantsForCyclone(scene.permissions()).applied_grant_for(scene.folder.certificate->subject()),
      &Candidate::grant);
  const bool has_own = std::ranges::any_of(
      all, [](const Candidate& one) { return one.subject.ddssec == Outcome::ok; });
  if (!has_own || taken == all.end() || taken->subject.cyclonedds != Outcome::unsafe) return;
  scene.out.report(
      {.cyclonedds = Outcome::unsafe},
      {.rule = Rule::DOC043,
       .message = fmt::format("the grant for \"{}\" stands first: {} takes it for \"{}\", whose "
                              "attributes are among its own, and not the grant for that subject",
                              taken->grant->subject_name.substr(0, 256),
                              name(Product::cyclonedds, scene.settings.lineup),
                              scene.folder.certificate->subject()),
       .document = scene.file(),
       .line = taken->grant->line,
       .hint = std::string(kStrayGrantHint),
       .severity = Severity::error});
}

void diagnose_second_grant(const Scene& scene, const std::vector<Candidate>& all) {
  if (all.size() < 2) return scene.out.pass(Rule::DOC043);
  scene.out.report({},
                   {.rule = Rule::DOC043,
                    .message = fmt::format("there are {} grants for \"{}\", at lines {} and {}: "
                                           "the second does not add to the first",
                                           all.size(), scene.folder.certificate->subject(),
                                           all[0].grant->line, all[1].grant->line),
                    .document = scene.file(),
                    .line = all[1].grant->line});
}

std::string why_not_joining(const Grant& grant, const Outcomes& outcomes, DomainId domain) {
  if (outcomes.ddssec == Outcome::ok)
    return fmt::format(
        "Cyclone DDS and Fast DDS read the open ranges of grant \"{}\" as one "
        "domain each, so no allow_rule is for domain {}",
        grant.name, domain);
  if (outcomes.cyclonedds == Outcome::ok)
    return fmt::format(
        "a deny_rule of grant \"{}\" without topics closes domain {} before an allow_rule opens it",
        grant.name, domain);
  std::vector<DomainRange> allowed;
  for (const auto& rule : grant.rules)
    if (rule.allow)
      allowed.insert(allowed.end(), rule.domains.ranges.begin(), rule.domains.ranges.end());
  return fmt::format("no allow_rule of grant \"{}\" is for domain {}; they are for {}", grant.name,
                     domain, allowed.empty() ? "none" : to_text(merged(std::move(allowed))));
}

// Fast DDS makes no participant by a grant without an allow_rule, for whatever domain, even if the
// governance document does not control joining (measured with 2.9.1). DOC052 reports it of a grant
// with <default>ALLOW.
bool lacks_allow_rule(const Grant& grant) {
  return !grant.default_allow && std::ranges::none_of(grant.rules, &governance::GrantRule::allow);
}

void report_no_allow_rule(const Scene& scene, const Grant& grant) {
  scene.out.report(
      {.fastdds = Outcome::fail},
      {.rule = Rule::DOC051,
       .message = fmt::format(
           "grant \"{}\" has no allow_rule, without which {} makes no participant, "
           "although <enable_join_access_control> is false in domain {}",
           grant.name, name(Product::fastdds, scene.settings.lineup), scene.settings.domain),
       .document = scene.file(),
       .line = grant.line,
       .hint = "add an allow_rule, for any topic, and sign the permissions again"});
}

void diagnose_join(const Scene& scene, const Grant& grant, const DomainRule* governance) {
  const CompiledGrant compiled(scene.folder.permissions.model, grant, scene.settings.domain);
  const bool asks = governance == nullptr || governance->enable_join_access_control;
  const auto outcome = [&](Product product, Outcome if_refused) {
    const bool joins = judge_participant_as(product, compiled, scene.settings.domain).allowed;
    return joins ? Outcome::ok : if_refused;
  };
  if (!asks && lacks_allow_rule(grant)) return report_no_allow_rule(scene, grant);
  const auto refused = measured(Variant::grant_other_domain, scene.settings.lineup);
  const auto fastdds = lacks_allow_rule(grant) ? Outcome::fail : refused.fastdds;
  Outcomes outcomes{.cyclonedds = outcome(Product::cyclonedds, refused.cyclonedds),
                    .fastdds = outcome(Product::fastdds, fastdds),
                    .ddssec = outcome(Product::ddssec, Outcome::fail)};
  // DOC052 reports that Fast DDS takes every default as DENY.
  if (compiled.judge_participant().allowed && grant.default_allow) outcomes.fastdds = Outcome::ok;
  if (!asks || outcomes.all_ok()) return scene.out.pass(Rule::DOC051);
  const auto mismatch = mismatch_texts(scene.folder, scene.settings.now);
  scene.out.report(outcomes, {.rule = Rule::DOC051,
                              .message = why_not_joining(grant, outcomes, scene.settings.domain) +
                                         mismatch.words,
                              .document = scene.file(),
                              .line = grant.line,
                              .hint = mismatch.hint});
}

void diagnose_default(const Scene& scene, const Grant& grant) {
  auto outcomes = measured(Variant::grant_default_allow, scene.settings.lineup);
  if (!grant.default_allow || outcomes.all_ok()) return scene.out.pass(Rule::DOC052);
  const bool any_allow = std::ranges::any_of(grant.rules, &governance::GrantRule::allow);
  if (!any_allow && outcomes.fastdds == Outcome::late) outcomes.fastdds = Outcome::fail;
  scene.out.report(
      outcomes, {.rule = Rule::DOC052,
                 .message = fmt::format("grant \"{}\" ends with <default>ALLOW</default>, which "
                                        "{} takes as DENY",
                                        grant.name, name(Product::fastdds, scene.settings.lineup)),
                 .document = scene.file(),
                 .line = grant.line});
}

void diagnose_permissions(const Scene& scene, const DomainRule* governance) {
  const auto all =
      candidates(scene.permissions(), *scene.folder.certificate, scene.settings.lineup);
  if (all.empty()) return report_no_grant(scene);
  diagnose_form(scene, all);
  diagnose_grant_dates(scene, all);
  diagnose_second_grant(scene, all);
  diagnose_cyclones_grant(scene, all);
  const auto* grant = grant_of(scene.folder, scene.settings.now);
  if (grant == nullptr) grant = all.front().grant;
  diagnose_local_time(scene, *grant);
  diagnose_fastdds_zones(scene, all);
  diagnose_join(scene, *grant, governance);
  diagnose_default(scene, *grant);
  diagnose_denials(scene.folder, scene.settings, *grant, scene.out);
}

// Something that expires, and when.
struct End {
  std::string what;
  WallTime when;
  fs::path document;
};

std::vector<End> ends_of(const LoadedFolder& folder, WallTime now) {
  std::vector<End> out;
  const auto add = [&](const fs::path& path, const pki::Certificate& certificate) {
    out.push_back(
        {path.filename().string() + " of " + certificate.subject(), certificate.not_after(), path});
  };
  if (folder.certificate) add(folder.paths.certificate, *folder.certificate);
  if (folder.identity_cas)
    for (const auto& ca : *folder.identity_cas) add(folder.paths.identity_ca, ca);
  if (folder.permissions_cas)
    for (const auto& ca : *folder.permissions_cas) add(folder.paths.permissions_ca, ca);
  if (folder.crls)
    for (const auto& crl : *folder.crls)
      if (crl.next_update())
        out.push_back({"crl.pem of " + crl.issuer(), *crl.next_update(), folder.paths.crl});
  if (const auto* grant = grant_of(folder, now))
    out.push_back(
        {"grant \"" + grant->name + '"', grant->validity.not_after, folder.paths.permissions});
  // Other checks report what has expired.
  std::erase_if(out, [&](const End& end) { return end.when <= now; });
  return out;
}

}  // namespace

const Grant* grant_of(const LoadedFolder& folder, WallTime now) {
  if (!folder.permissions.model || !folder.certificate) return nullptr;
  const auto found =
      find_grant(*folder.permissions.model, pki::SubjectName::of(*folder.certificate),
                 folder.certificate->subject(), now);
  return found ? *found : nullptr;
}

void diagnose_rights(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  const auto* rule = diagnosed_domain_rule(folder, settings, out);
  if (folder.permissions.model && folder.certificate)
    diagnose_permissions({folder, settings, out}, rule);
}

void diagnose_ends(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  const auto ends = ends_of(folder, settings.now);
  if (ends.empty()) return;
  const auto first = std::ranges::min_element(ends, {}, &End::when);
  if (first->when > settings.now + kSoon) return out.pass(Rule::DOC041);
  const auto left = std::chrono::floor<std::chrono::hours>(first->when - settings.now).count();
  out.report({}, {.rule = Rule::DOC041,
                  .message = fmt::format("{} ends first, at {}: in {} d {} h; a participant "
                                         "that is connected then is cut off",
                                         first->what, to_string(first->when), left / 24, left % 24),
                  .document = first->document});
}

}  // namespace ddssec::governance::doctor
