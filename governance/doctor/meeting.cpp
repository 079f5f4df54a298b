#include "governance/doctor/meeting.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "governance/cyclonedds_subject.hpp"
#include "governance/decision.hpp"
#include "governance/doctor/chain_outcomes.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/meeting_steps.hpp"
#include "governance/doctor/product_decision.hpp"
#include "governance/doctor/subject_form.hpp"
#include "governance/grant.hpp"
#include "governance/refusal_advice.hpp"
#include "pki/certificate_source.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// The judgement of `judge` about the certificate of `subject`.
Status check_certificate(const Party& judge, const Party& subject, WallTime now) {
  const auto& certificate = subject.folder.certificate;
  if (!certificate) return std::unexpected(certificate.error());
  if (!judge.folder.identity_cas) return std::unexpected(judge.folder.identity_cas.error());
  if (!judge.folder.has_usable_lists(judge.product))
    return std::unexpected(judge.folder.crls.error());
  // Stock products also take CAs with which ddssec makes no verifier.
  const auto verifier = judge.folder.chain(judge.product);
  const auto proof = verifier ? verifier->verify(*certificate, now)
                              : Result<pki::ValidChain>(std::unexpected(verifier.error()));
  const auto outcomes = chain_outcomes(*certificate, *judge.folder.identity_cas, proof,
                                       WrongDates::count, judge.lineup);
  if (outcomes.of(judge.product) == Outcome::ok) return {};
  if (!proof) return std::unexpected(proof.error());
  return fail(Code::issuer_unknown,
              {.expected = "\"" + certificate->issuer() + "\", self-signed",
               .note = judge.product_name() + " reads fewer CA files than ours"});
}

std::string ca_subjects(const Result<std::vector<pki::Certificate>>& cas) {
  std::string out;
  if (!cas) return "nothing readable";
  for (const auto& ca : *cas)
    if (out.size() < 256) out += (out.empty() ? "\"" : ", \"") + ca.subject() + '"';
  return out;
}

// Returns the error's hint, or nothing for the code `cause_in_cas`: the rule's own hint fits that
// cause.
std::string hint_for(Code cause_in_cas, const Error& error) {
  return error.code() == cause_in_cas ? std::string() : error.hint();
}

std::string ca_subjects_clause(Code cause_in_cas, const Error& error, std::string_view party,
                               const fs::path& file,
                               const Result<std::vector<pki::Certificate>>& cas) {
  if (error.code() != cause_in_cas) return {};
  return fmt::format("; {} of {} holds {}", file.filename().string(), party, ca_subjects(cas));
}

bool is_about_lists(Code code) {
  return code == Code::certificate_revoked || code == Code::crl_is_delta ||
         (Code::crl_malformed <= code && code <= Code::crl_signature_invalid);
}

// True if the certificate itself is out of date. Then the finding names its file; if a CA is out of
// date, the finding names the judge's file.
bool is_out_of_date(const Result<pki::Certificate>& certificate, WallTime now) {
  return certificate && (now < certificate->not_before() || certificate->not_after() < now);
}

void diagnose_authentication(const MeetingScene& scene, int judge) {
  const auto& self = scene.party(judge);
  const auto& other = scene.party(1 - judge);
  const auto status = check_certificate(self, other, scene.settings.now);
  PartyDecision out{.judge = judge, .about = 1 - judge, .ok = status.has_value()};
  out.document = self.folder.paths.identity_ca.string();
  if (!status) {
    if (is_about_lists(status.error().code())) out.document = self.folder.paths.crl.string();
    if (is_about_dates(status.error().code()) &&
        is_out_of_date(other.folder.certificate, scene.settings.now))
      out.document = other.folder.paths.certificate.string();
    out.reason = status.error().message();
    // DOC090 reports unreadable files to their owner.
    const auto& certificate = other.folder.certificate;
    if (certificate && self.folder.identity_cas && self.folder.has_usable_lists(self.product))
      add_finding(
          scene, Rule::DOC080, out,
          fmt::format("{} does not accept {}'s certificate ({} serial {}, issued by "
                      "\"{}\"): {}{}",
                      self.name, other.name, certificate->subject(), certificate->serial(),
                      certificate->issuer(), out.reason,
                      ca_subjects_clause(Code::issuer_unknown, status.error(), self.name,
                                         self.folder.paths.identity_ca, self.folder.identity_cas)),
          hint_for(Code::issuer_unknown, status.error()));
  }
  scene.out.authentication.push_back(std::move(out));
}

// Fast DDS also accepts the one-line form in the permissions of a remote participant.
bool reads_remote_subject(const Grant& grant, const pki::Certificate& certificate,
                          const Party& judge) {
  if (judge.product == Product::fastdds && grant.subject_name == certificate.subject_one_line())
    return true;
  if (judge.product == Product::ddssec) return is_for(grant, pki::SubjectName::of(certificate));
  const auto outcomes = reads_subject(grant.subject_name, certificate, judge.lineup);
  return outcomes.of(judge.product) != Outcome::fail;
}

Status check_permissions_of(const Party& judge, const Party& subject, WallTime now) {
  const auto& document = subject.folder.permissions;
  if (!document.readable) return document.readable;
  if (judge.product == Product::ddssec && document.file.size() > pki::kMaxSentPermissionsOctets)
    return fail(Code::permissions_too_large,
                {.expected = fmt::format("at most {} octets", pki::kMaxSentPermissionsOctets),
                 .found = fmt::format("{} octets", document.file.size())});
  const bool is_fastdds = judge.product == Product::fastdds && subject.product == Product::fastdds;
  if (is_fastdds && handshake_octets(subject.folder) > kMaxFastDdsHandshakeOctets)
    return fail(Code::permissions_too_large,
                {.expected = fmt::format("at most {} octets with the certificate",
                                         kMaxFastDdsHandshakeOctets),
                 .found = fmt::format("{} octets", handshake_octets(subject.folder)),
                 .note = "Fast DDS does not authenticate a Fast DDS participant with more"});
  DDSSEC_RETURN_IF_ERROR(verify_signature_as(judge.product, document.file,
                                             judge.folder.permissions_cas,
                                             judge.folder.permissions_ca_file, now));
  DDSSEC_RETURN_IF_ERROR(document.read_by(judge.product));
  if (!subject.folder.certificate) return std::unexpected(subject.folder.certificate.error());
  const auto& certificate = *subject.folder.certificate;
  for (const auto& grant : document.model->grants)
    if (reads_remote_subject(grant, certificate, judge)) {
      if (validity_as(judge.product, grant.validity).contains(now)) return {};
      if (!grant.validity.contains(now)) continue;
      return fail(Code::grant_expired,
                  {.line = grant.line,
                   .note = judge.product == Product::cyclonedds
                               ? "Cyclone DDS reads <not_after> as a time that has passed"
                               : "Fast DDS ignores the zones of the validity"});
    }
  const auto found =
      find_grant(*document.model, pki::SubjectName::of(certificate), certificate.subject(), now);
  if (!found) return std::unexpected(found.error());
  return fail(Code::no_grant_for_subject,
              {.expected = certificate.subject(), .found = (*found)->subject_name});
}

// The grant that ddssec would apply, or a grant that a product of the meeting considers valid.
const Grant* applied_grant(const MeetingScene& scene, int about) {
  const auto& folder = scene.folder(about);
  if (const auto* grant = grant_of(folder, scene.settings.now)) return grant;
  if (!folder.permissions.model || !folder.certificate) return nullptr;
  const auto& grants = folder.permissions.model->grants;
  const auto found = std::ranges::find_if(grants, [&](const Grant& grant) {
    return std::ranges::any_of(kBoth, [&](int judge) {
      const auto& party = scene.party(judge);
      return reads_remote_subject(grant, *folder.certificate, party) &&
             validity_as(party.product, grant.validity).contains(scene.settings.now);
    });
  });
  return found == grants.end() ? nullptr : &*found;
}

// Adds a note if Cyclone DDS would apply a grant of another subject where this product refuses.
void note_taken_by_cyclonedds(const MeetingScene& scene, int judge, const Error& error) {
  const auto& subject = scene.party(1 - judge).folder;
  if (error.code() != Code::no_grant_for_subject || !subject.permissions.model) return;
  for (const auto& grant : subject.permissions.model->grants) {
    if (!cyclonedds_applies_grant(grant.subject_name, subject.certificate->subject())) continue;
    scene.out.notes.push_back(
        {.rule = Rule::DOC011,
         .message = fmt::format("{} on Cyclone DDS's own plugins would accept the grant for \"{}\" "
                                "from \"{}\": these compare the certificate's attributes only",
                                scene.party(judge).name, grant.subject_name.substr(0, 256),
                                subject.certificate->subject()),
         .document = subject.paths.permissions.string(),
         .line = grant.line,
         .severity = Severity::warning});
    return;
  }
}

// Fast DDS announces the first certificate of its permissions CA file, and compares what another
// Fast DDS announces with its own (measured with 2.9.1). No other product announces one.
std::string why_announced_cas_differ(const Party& judge, const Party& subject) {
  if (judge.product != Product::fastdds || subject.product != Product::fastdds) return {};
  const auto own = pki::ca_announced_by_fastdds(judge.folder.permissions_ca_file);
  const auto other = pki::ca_announced_by_fastdds(subject.folder.permissions_ca_file);
  if (!own || !other || own == other) return {};
  return fmt::format(
      "Fast DDS compares the first certificates of the permissions CA files: \"{}\" ({}) at {}, "
      "\"{}\" ({}) at {}",
      own->name, own->algorithm, judge.name, other->name, other->algorithm, subject.name);
}

void diagnose_announced_ca(const MeetingScene& scene, int judge, PartyDecision& out) {
  const auto& self = scene.party(judge);
  const auto& other = scene.party(1 - judge);
  out.reason = why_announced_cas_differ(self, other);
  if (out.reason.empty()) return;
  out.ok = false;
  out.document = other.folder.paths.permissions_ca.string();
  add_finding(
      scene, Rule::DOC081, out,
      fmt::format("{} does not accept {}'s permissions: {}", self.name, other.name, out.reason),
      "begin the permissions CA files of both with the same certificate");
}

void diagnose_permissions(const MeetingScene& scene, int judge) {
  const auto& self = scene.party(judge);
  const auto& other = scene.party(1 - judge);
  const auto status = check_permissions_of(self, other, scene.settings.now);
  PartyDecision out{.judge = judge, .about = 1 - judge, .ok = status.has_value()};
  out.document = other.folder.paths.permissions.string();
  if (!status) {
    out.reason = status.error().message();
    out.line = status.error().details().line;
    constexpr auto kForeign = Code::smime_signer_not_permissions_ca;
    if (other.folder.certificate && self.product != Product::cyclonedds)
      note_taken_by_cyclonedds(scene, judge, status.error());
    if (other.folder.permissions.readable && other.folder.certificate &&
        self.folder.permissions_cas)
      add_finding(
          scene, Rule::DOC081, out,
          fmt::format(
              "{} does not accept {}'s permissions: {}{}", self.name, other.name, out.reason,
              ca_subjects_clause(kForeign, status.error(), self.name,
                                 self.folder.paths.permissions_ca, self.folder.permissions_cas)),
          hint_for(kForeign, status.error()));
  } else {
    diagnose_announced_ca(scene, judge, out);
  }
  scene.out.permissions.push_back(std::move(out));
}

void diagnose_join(const MeetingScene& scene, int judge, int about) {
  const auto* rule = scene.out.rules[judge];
  const auto& folder = scene.folder(about);
  PartyDecision out{.judge = judge, .about = about, .ok = true};
  const auto* grant = scene.grants[about].get();
  if (rule == nullptr) {
    out.ok = false;
    out.document = scene.folder(judge).paths.governance.string();
    out.reason = fmt::format("no <domain_rule> covers domain {}", scene.settings.domain);
  } else if (rule->enable_join_access_control && grant != nullptr) {
    const auto decision =
        judge_participant_as(scene.party(judge).product, *grant, scene.settings.domain);
    out.ok = decision.allowed;
    out.grant = grant->grant().name;
    out.document = folder.paths.permissions.string();
    out.line = decision.line(grant->grant());
    out.reason =
        fmt::format("{} rule of grant \"{}\" for domain {}",
                    decision.allowed ? "an allow" : "no allow", out.grant, scene.settings.domain);
    if (!out.ok && judge != about)
      add_finding(scene, Rule::DOC088, out,
                  fmt::format("{} does not let {} join domain {}: {}", scene.party(judge).name,
                              scene.party(about).name, scene.settings.domain, out.reason));
  }
  scene.out.join.push_back(std::move(out));
}

void compare_governance(const MeetingScene& scene) {
  for (const int i : kBoth)
    if (scene.folder(i).governance.model)
      scene.out.rules[i] = domain_rule_as(scene.party(i).product, *scene.folder(i).governance.model,
                                          scene.settings.domain);
  if (scene.out.rules[0] == nullptr || scene.out.rules[1] == nullptr) return;
  scene.out.differences = differences(*scene.out.rules[0], *scene.out.rules[1]);
  for (const auto& difference : scene.out.differences)
    scene.out.findings.push_back(
        {.rule = Rule::DOC082,
         .message = sentence(scene, difference) + ": participants must agree in it",
         .document = scene.folder(1).paths.governance.string(),
         .line = difference.lines[1]});
}

// False if the initiator is Fast DDS and the replier Cyclone DDS. Fast DDS then proposes
// DH+MODP-2048-256 in a form that Cyclone DDS cannot read (2.9.1 and 0.10.2).
bool handshake_works(Product initiator, Product replier) {
  return !(initiator == Product::fastdds && replier == Product::cyclonedds);
}

std::string handshake_sentence(const Party& starts, const Party& waits, bool by_chance) {
  const auto& subject = starts.folder.certificate->subject();
  const auto who =
      by_chance ? fmt::format(
                      "{} starts the handshake at some starts and {} at others, because "
                      "both have the subject \"{}\"; where {} starts it and",
                      starts.name, waits.name, subject, starts.name)
                : fmt::format("{} starts the handshake, by the hashes of \"{}\" and \"{}\"; if it",
                              starts.name, subject, waits.folder.certificate->subject());
  return fmt::format(
      "{} runs Fast DDS 2.9.1 and {} runs Cyclone DDS with its own plugins, they never "
      "authenticate: Cyclone DDS cannot read the Diffie-Hellman value that Fast DDS proposes",
      who, waits.name);
}

void diagnose_handshake_from(const MeetingScene& scene, int starts) {
  const auto& first = scene.party(starts);
  const auto& second = scene.party(1 - starts);
  Finding finding{
      .rule = Rule::DOC083,
      .message = handshake_sentence(first, second, scene.out.starter == Starter::chance),
      .document = first.folder.paths.certificate.string()};
  if (!handshake_works(first.product, second.product)) {
    scene.out.handshake_works = false;
    scene.out.findings.push_back(std::move(finding));
  } else if (scene.out.starter != Starter::chance && first.product == Product::ddssec &&
             second.product == Product::ddssec) {
    finding.severity = Severity::informational;
    scene.out.notes.push_back(std::move(finding));
  }
}

void diagnose_handshake(const MeetingScene& scene) {
  if (!scene.folder(0).certificate || !scene.folder(1).certificate) return;
  scene.out.starter = starter(*scene.folder(0).certificate, *scene.folder(1).certificate);
  if (scene.out.starter != Starter::chance)
    return diagnose_handshake_from(scene, scene.out.starter == Starter::first ? 0 : 1);
  scene.out.notes.push_back(
      {.rule = Rule::DOC089,
       .message = fmt::format("both certificates have the subject \"{}\": which of the two starts "
                              "the handshake is left to chance at each start",
                              scene.folder(0).certificate->subject()),
       .document = scene.folder(1).paths.certificate.string()});
  for (const int i : kBoth) diagnose_handshake_from(scene, i);
}

// Since 2.10 Fast DDS waits for a peer's data of DCPSParticipantsSecure, which Cyclone DDS 0.10
// never writes, and no plugin can change that. Cyclone DDS 11 was not tried with such a Fast DDS.
constexpr Version kFastDdsThatWaits{2, 10, 0};
constexpr Version kCycloneDdsNotTried{11, 0, 0};

void diagnose_discovery(const MeetingScene& scene, int fast) {
  const auto& self = scene.party(fast);
  const auto& other = scene.party(1 - fast);
  if (self.product != Product::fastdds || other.product == Product::fastdds) return;
  Finding finding{.rule = Rule::DOC094, .message = {}};
  if (self.lineup.fastdds < kFastDdsThatWaits) {
    finding.message = fmt::format(
        "this is predicted for {}: secured, Fast DDS 2.10 and later discovers nothing of Cyclone "
        "DDS 0.10, with its own plugins or with ddssec's",
        self.product_name());
  } else if (other.product == Product::ddssec) {
    finding.message = fmt::format(
        "secured, {} discovers nothing of Cyclone DDS 0.10 with ddssec's plugins in it, only of "
        "ddssec's embedded participant",
        self.product_name());
  } else if (other.lineup.cyclonedds >= kCycloneDdsNotTried) {
    finding.message = fmt::format(
        "whether {} and {} find each other, secured, was not tried: Fast DDS 2.10 and "
        "later discovers nothing of Cyclone DDS 0.10",
        self.product_name(), other.product_name());
  } else {
    scene.out.discovery_works = false;
    finding.message = fmt::format("secured, {} ({}) discovers nothing of {} ({})",
                                  self.product_name(), self.name, other.product_name(), other.name);
    finding.severity = Severity::error;
    scene.out.findings.push_back(std::move(finding));
    return;
  }
  scene.out.notes.push_back(std::move(finding));
}

bool all_ok(const std::vector<PartyDecision>& judgements) {
  return std::ranges::all_of(judgements, &PartyDecision::ok);
}

std::string_view verb(Action action) {
  return action == Action::publish ? "publish" : "subscribe to";
}

// A name that one side has and the other side has almost: one of them is probably a typo. At most
// 100 names of one side are compared in one direction.
std::string near_miss(const MeetingScene& scene, int names, Action action) {
  constexpr std::size_t kMaxNames = 100;
  const int other = 1 - names;
  const auto theirs = action == Action::publish ? Action::subscribe : Action::publish;
  std::size_t count = 0;
  for (const auto* criteria : scene.grants[names]->allowed(action))
    for (const auto& topic : criteria->topics) {
      if (!Pattern(topic.text).is_literal()) continue;
      if (++count > kMaxNames) return {};
      const auto near = advice_on_name(*scene.grants[other], theirs, topic.text).because;
      if (!near.empty())
        return fmt::format("; {} may {} \"{}\", and of {} to {} {}: is one of them misspelt?",
                           scene.party(names).name, verb(action), topic.text,
                           scene.party(other).name, verb(theirs), near);
    }
  return {};
}

std::string near_misses(const MeetingScene& scene) {
  if (scene.grants[0] == nullptr || scene.grants[1] == nullptr) return {};
  for (const int names : kBoth)
    for (const auto action : {Action::publish, Action::subscribe})
      if (auto found = near_miss(scene, names, action); !found.empty()) return found;
  return {};
}

void report_no_topic(const MeetingScene& scene) {
  // If the permissions allow some topic, another cause separates the parties and has its own
  // finding.
  const auto is_allowed = [](const TopicDirection& one) { return all_ok(one.steps); };
  const bool any = std::ranges::any_of(scene.out.topics, [&](const TopicMeeting& topic) {
    return std::ranges::any_of(topic.directions, is_allowed);
  });
  if (any || !scene.out.joined()) return;
  if (!scene.out.topics_complete) {
    scene.out.findings.push_back(
        {.rule = Rule::DOC086,
         .message =
             fmt::format("no topic was found that {} may publish and {} subscribe to, or the "
                         "other way round, and not every topic was looked at: the "
                         "expressions have too many combinations",
                         scene.party(0).name, scene.party(1).name),
         .document = scene.folder(0).paths.permissions.string(),
         .hint = "name the topic that is meant: ddssec check A B --topics TOPIC",
         .severity = Severity::warning});
    return;
  }
  scene.out.findings.push_back(
      {.rule = Rule::DOC086,
       .message = fmt::format("there is no topic that {} may publish and {} subscribe to, or the "
                              "other way round{}",
                              scene.party(0).name, scene.party(1).name, near_misses(scene)),
       .document = scene.folder(0).paths.permissions.string()});
}

}  // namespace

void add_finding(const MeetingScene& scene, Rule rule, const PartyDecision& judgement,
                 std::string message, std::string hint) {
  scene.out.findings.push_back({.rule = rule,
                                .message = std::move(message),
                                .document = judgement.document,
                                .line = judgement.line,
                                .hint = std::move(hint)});
}

bool Meeting::joined() const {
  return all_ok(start) && all_ok(authentication) && all_ok(permissions) && all_ok(join) &&
         differences.empty() && handshake_works && discovery_works && properties_fit &&
         rules[0] != nullptr && rules[1] != nullptr;
}

// The first 48 bits of the GUID: a 1 bit and the first 47 bits of the subject's hash.
std::uint64_t guid_start(const pki::Certificate& certificate) {
  constexpr std::uint64_t kAdjusted = std::uint64_t{1} << 47;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 6; ++i) bits = bits << 8 | certificate.subject_digest()[i];
  return kAdjusted | bits >> 1;
}

Starter starter(const pki::Certificate& a, const pki::Certificate& b) {
  const auto first = guid_start(a);
  const auto second = guid_start(b);
  if (first == second) return Starter::chance;
  return first < second ? Starter::first : Starter::second;
}

Meeting predict_meeting(const Party& a, const Party& b, const Settings& settings,
                        const std::vector<std::string>& topics) {
  Meeting out;
  MeetingScene scene{{&a, &b}, settings, out, !topics.empty()};
  for (const int i : kBoth)
    if (const auto* grant = applied_grant(scene, i))
      scene.grants[i] = std::make_unique<const CompiledGrant>(scene.folder(i).permissions.model,
                                                              *grant, settings.domain);
  for (const int i : kBoth) diagnose_start(scene, i);
  if (a.folder.is_empty() || b.folder.is_empty()) return out;
  for (const int judge : {1, 0}) diagnose_authentication(scene, judge);
  for (const int judge : {1, 0}) diagnose_permissions(scene, judge);
  compare_governance(scene);
  for (const int judge : kBoth)
    for (const int about : kBoth) diagnose_join(scene, judge, about);
  diagnose_handshake(scene);
  for (const int i : kBoth) diagnose_discovery(scene, i);
  for (const auto& topic : topics) predict_topic(scene, {.name = topic});
  if (scene.named) return out;
  for (const auto& topic : topics_of_interest(scene)) predict_topic(scene, topic);
  report_no_topic(scene);
  return out;
}

}  // namespace ddssec::governance::doctor
