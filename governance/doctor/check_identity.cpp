// Certificate, key, CA, revocation.
#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "governance/doctor/ca_list.hpp"
#include "governance/doctor/chain_outcomes.hpp"
#include "governance/doctor/checks.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr Outcomes kNobody = Outcomes::all(Outcome::fail);

std::string name_of(const fs::path& path) { return path.filename().string(); }

bool is_valid(const pki::Certificate& certificate, WallTime now) {
  return certificate.not_before() <= now && now <= certificate.not_after();
}

std::string dates_wrong(const fs::path& path, const pki::Certificate& certificate, WallTime now) {
  const bool early = now < certificate.not_before();
  return fmt::format("{} of {}: {} is {}, now it is {}", name_of(path), certificate.subject(),
                     early ? "notBefore" : "notAfter",
                     to_string(early ? certificate.not_before() : certificate.not_after()),
                     to_string(now));
}

// Cyclone DDS 0.10.2 takes RSA of exactly 2048 bits and EC P-256.
bool cyclonedds_reads(pki::KeyAlgorithm key) {
  return key == pki::KeyAlgorithm{pki::KeyKind::rsa, 2048} || key.kind == pki::KeyKind::ec_p256;
}

void check_key_types(const LoadedFolder& folder, Diagnosis& out) {
  const auto look = [&](const pki::Certificate& certificate, const fs::path& path) {
    const auto key = certificate.key_algorithm();
    if (cyclonedds_reads(key)) return out.pass(Rule::DOC014);
    out.report({.cyclonedds = Outcome::fail},
               {.rule = Rule::DOC014,
                .message = fmt::format("{} of {} has a key of {}; Cyclone DDS 0.10.2 reads "
                                       "EC-prime256v1 and RSA-2048 only",
                                       name_of(path), certificate.subject(), to_string(key)),
                .document = path});
  };
  if (folder.certificate) look(*folder.certificate, folder.paths.certificate);
  if (!folder.identity_cas) return;
  for (const auto& ca : *folder.identity_cas) look(ca, folder.paths.identity_ca);
}

void check_pair(const LoadedFolder& folder, Diagnosis& out) {
  if (!folder.key || !folder.certificate) return;
  if (folder.key->matches(*folder.certificate)) return out.pass(Rule::DOC012);
  out.report({.cyclonedds = Outcome::late, .fastdds = Outcome::fail, .ours = Outcome::fail},
             {.rule = Rule::DOC012,
              .message = fmt::format("{} ({}) is not the private half of the key in {} ({} of {}); "
                                     "Cyclone DDS starts all the same and never authenticates",
                                     name_of(folder.paths.key), to_string(folder.key->algorithm()),
                                     name_of(folder.paths.certificate),
                                     to_string(folder.certificate->key_algorithm()),
                                     folder.certificate->subject()),
              .document = folder.paths.key});
}

void check_dates(const LoadedFolder& folder, WallTime now, Diagnosis& out) {
  if (folder.certificate && is_valid(*folder.certificate, now)) out.pass(Rule::DOC021);
  if (folder.certificate && !is_valid(*folder.certificate, now))
    out.report(kNobody, {.rule = Rule::DOC021,
                         .message = dates_wrong(folder.paths.certificate, *folder.certificate, now),
                         .document = folder.paths.certificate});
  const auto look = [&](const auto& cas, const fs::path& path) {
    if (!cas) return;
    out.pass(Rule::DOC022);
    for (const auto& ca : *cas)
      if (!is_valid(ca, now))
        out.report(kNobody,
                   {.rule = Rule::DOC022, .message = dates_wrong(path, ca, now), .document = path});
  };
  look(folder.identity_cas, folder.paths.identity_ca);
  look(folder.permissions_cas, folder.paths.permissions_ca);
}

std::string subjects(const std::vector<pki::Certificate>& certificates) {
  std::string out;
  for (const auto& one : certificates)
    if (out.size() < 256) out += (out.empty() ? "\"" : ", \"") + one.subject() + '"';
  return out;
}

bool has_subject(const std::vector<pki::Certificate>& cas, const std::string& subject) {
  return std::ranges::any_of(cas,
                             [&](const pki::Certificate& ca) { return ca.subject() == subject; });
}

// One sentence that names the CA that issued and the CA that is configured.
std::string chain_broken(const LoadedFolder& folder, const Error& error) {
  const auto file = name_of(folder.paths.certificate);
  const auto ca_file = name_of(folder.paths.identity_ca);
  const auto& certificate = *folder.certificate;
  const bool is_issuer =
      error.code() == Code::issuer_unknown || error.code() == Code::certificate_signature_invalid;
  if (!is_issuer) return fmt::format("{} of {}: {}", file, certificate.subject(), error.message());
  if (has_subject(*folder.identity_cas, certificate.issuer()))
    return fmt::format(
        "{} of {} names \"{}\" as its issuer, but the CA of that name in {} did not "
        "sign it: there are two CAs of one name",
        file, certificate.subject(), certificate.issuer(), ca_file);
  return fmt::format("{} of {} was issued by \"{}\", and {} holds {}", file, certificate.subject(),
                     certificate.issuer(), ca_file, subjects(*folder.identity_cas));
}

// For a path that only ours, or ours and Fast DDS, can follow.
std::string needs_other_ca_file(const LoadedFolder& folder) {
  return fmt::format(
      "{} of {} was issued by \"{}\"; Cyclone DDS 0.10.2 needs that CA, self-signed, as the first "
      "certificate of {}, and Fast DDS 2.9.1 the whole path up to a self-signed CA; it holds {}",
      name_of(folder.paths.certificate), folder.certificate->subject(),
      folder.certificate->issuer(), name_of(folder.paths.identity_ca),
      subjects(*folder.identity_cas));
}

// Wrong dates have a rule of their own; the rest is judged as of a day when the certificate is
// valid, so that they hide nothing.
WallTime time_to_judge(const LoadedFolder& folder, WallTime now) {
  WallTime time = now;
  if (!is_valid(*folder.certificate, now)) time = folder.certificate->not_before();
  for (const auto& ca : *folder.identity_cas)
    if (ca.subject() == folder.certificate->issuer() && !is_valid(ca, time))
      time = std::max(folder.certificate->not_before(), ca.not_before());
  return time;
}

void check_chain(const LoadedFolder& folder, WallTime now, Diagnosis& out) {
  if (!folder.certificate || !folder.identity_cas) return;
  const auto verifier = pki::ChainVerifier::make(*folder.identity_cas);
  const auto proof = verifier ? verifier->verify(*folder.certificate, time_to_judge(folder, now))
                              : Result<pki::ChainValid>(std::unexpected(verifier.error()));
  const auto outcomes = chain_outcomes(*folder.certificate, *folder.identity_cas, proof, true);
  if (outcomes.all_ok()) return out.pass(Rule::DOC020);
  const bool only_stock = outcomes.ours == Outcome::ok;
  out.report(outcomes, {.rule = Rule::DOC020,
                        .message = only_stock ? needs_other_ca_file(folder)
                                              : chain_broken(folder, proof.error()),
                        .document = folder.paths.certificate});
}

std::string crl_wrong(const LoadedFolder& folder, const Error& error) {
  const auto file = name_of(folder.paths.crl);
  const auto& crls = *folder.crls;
  if (error.code() == Code::crl_missing)
    return fmt::format("{} holds no list of \"{}\", which issued the certificate; it holds {}",
                       file, folder.certificate->issuer(),
                       crls.empty() ? "none" : '"' + crls.front().issuer() + '"');
  return fmt::format("{}: {}", file, error.message());
}

std::string own_list(const LoadedFolder& folder) {
  const auto file = name_of(folder.paths.crl);
  if (folder.crls->empty()) return fmt::format("there is no {} here", file);
  return fmt::format("{} here is list {}", file, folder.crls->front().number().value_or(0));
}

// The CA's own list, if it lies beside the participant and is newer than the participant's.
void check_ca_list(const LoadedFolder& folder, Diagnosis& out) {
  if (!folder.crls || !folder.certificate || !folder.identity_cas) return;
  const auto newer = newer_ca_list(folder.paths, *folder.identity_cas, *folder.crls);
  if (!newer) return;
  const auto number = newer->list.number().value_or(0);
  if (names(newer->list, *folder.certificate))
    return out.report(
        kNobody, {.rule = Rule::DOC024,
                  .message = fmt::format(
                      "{} of {} (serial {}) is revoked by list {} of the CA, {}; "
                      "{}",
                      name_of(folder.paths.certificate), folder.certificate->subject(),
                      folder.certificate->serial(), number, newer->file.string(), own_list(folder)),
                  .document = newer->file});
  if (!folder.has_crl_file) return;  // said by check_revocation
  out.report({}, {.rule = Rule::DOC023,
                  .message = fmt::format("the CA has list {}, {}; {}", number, newer->file.string(),
                                         own_list(folder)),
                  .document = folder.paths.crl,
                  .hint = "put the CA's list into the participants' folders: ddssec crl distribute",
                  .severity = Severity::warning});
}

void check_revocation(const LoadedFolder& folder, WallTime now, Diagnosis& out) {
  if (!folder.has_crl_file && !folder.is_empty())
    out.report({},
               {.rule = Rule::DOC023,
                .message = fmt::format("there is no {}: a revoked certificate still counts here",
                                       name_of(folder.paths.crl)),
                .document = folder.paths.folder,
                .hint = "put the CA's list there: ddssec crl distribute --ca CA; without a "
                        "list of it, ddssec crl new --ca CA makes one",
                .severity = Severity::warning});
  if (!folder.has_crl_file || !folder.crls || !folder.certificate || !folder.identity_cas) return;
  const auto verifier = folder.chain();
  if (!verifier) return;  // said by check_chain
  const auto proof = verifier->verify(*folder.certificate, now);
  const auto code = proof ? Code::usage : proof.error().code();
  const bool is_revoked = code == Code::certificate_revoked;
  const bool is_list = Code::crl_malformed <= code && code <= Code::crl_signature_invalid;
  if (!is_revoked) out.pass(Rule::DOC024);
  if (!is_list) out.pass(Rule::DOC023);
  if (is_revoked)
    out.report(kNobody, {.rule = Rule::DOC024,
                         .message = fmt::format(
                             "{} names serial {}, which is {} in {}: it was revoked",
                             name_of(folder.paths.crl), folder.certificate->serial(),
                             folder.certificate->subject(), name_of(folder.paths.certificate)),
                         .document = folder.paths.crl});
  if (is_list)
    out.report(kNobody, {.rule = Rule::DOC023,
                         .message = crl_wrong(folder, proof.error()),
                         .document = folder.paths.crl});
}

}  // namespace

void check_identity(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  check_key_types(folder, out);
  check_pair(folder, out);
  check_chain(folder, settings.now, out);
  check_dates(folder, settings.now, out);
  check_revocation(folder, settings.now, out);
  check_ca_list(folder, out);
}

}  // namespace ddssec::governance::doctor
