// Checks certificate, key, CA and revocation.
#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "governance/doctor/ca_list.hpp"
#include "governance/doctor/chain_outcomes.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "pki/issue_log.hpp"
#include "pki/key_digests.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

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

enum class CertificateOf : std::uint8_t { participant, ca };

// The variant for a kind of key that not every product accepts.
std::optional<Variant> unusual_key(pki::KeyAlgorithm key, CertificateOf whose) {
  if (key == pki::KeyAlgorithm{pki::KeyKind::rsa, 2048} || key.kind == pki::KeyKind::ec_p256)
    return std::nullopt;
  if (key.kind == pki::KeyKind::rsa) return Variant::rsa_3072;
  return whose == CertificateOf::ca ? Variant::ca_p384 : Variant::p384;
}

// Calls `look` for the identity certificate and for each CA of its file.
template <class Look>
void for_each_certificate(const LoadedFolder& folder, Look look) {
  if (folder.certificate)
    look(*folder.certificate, folder.paths.certificate, CertificateOf::participant);
  if (!folder.identity_cas) return;
  for (const auto& ca : *folder.identity_cas) look(ca, folder.paths.identity_ca, CertificateOf::ca);
}

// "Cyclone DDS 0.10.2", "Cyclone DDS 0.10.2 and Fast DDS 2.9.1": the products that refuse.
std::string who_refuses(const Outcomes& outcomes, const Lineup& lineup) {
  std::string out;
  for (const auto product : {Product::cyclonedds, Product::fastdds})
    if (outcomes.of(product) != Outcome::ok)
      out += (out.empty() ? "" : " and ") + name(product, lineup);
  return out;
}

void diagnose_key_types(const LoadedFolder& folder, const Lineup& lineup, Diagnosis& out) {
  for_each_certificate(folder, [&](const pki::Certificate& certificate, const fs::path& path,
                                   CertificateOf whose) {
    const auto key = certificate.key_algorithm();
    const auto variant = unusual_key(key, whose);
    const auto outcomes = variant ? measured(*variant, lineup) : Outcomes();
    if (outcomes.all_ok()) return out.pass(Rule::DOC014);
    out.report(outcomes, {.rule = Rule::DOC014,
                          .message = fmt::format(
                              "{} of {} has a key of {}; {} reads EC-prime256v1 and RSA-2048 only",
                              name_of(path), certificate.subject(), to_string(key),
                              who_refuses(outcomes, lineup)),
                          .document = path});
  });
}

// Measured with Fast DDS 2.9.1: it refuses SHA-1, SHA-224 and RSASSA-PSS as it refuses SHA-512.
// Ed25519 names no digest, and is read.
void diagnose_digest(const pki::Certificate& certificate, const fs::path& path, Variant variant,
                     const Lineup& lineup, Diagnosis& out) {
  const auto digest = certificate.signature_digest();
  const bool is_other = !digest.empty() && digest != "SHA256";
  const auto outcomes = is_other ? measured(variant, lineup) : Outcomes();
  if (outcomes.all_ok()) return out.pass(Rule::DOC015);
  out.report(outcomes,
             {.rule = Rule::DOC015,
              .message = fmt::format("{} of {} is signed with {}; {} reads certificates that are "
                                     "signed with SHA-256 only",
                                     name_of(path), certificate.subject(), digest,
                                     who_refuses(outcomes, lineup)),
              .document = path});
}

// A CA of X.509 version 1 has no extension that marks it as a CA. ddssec accepts it as a trust
// anchor.
void diagnose_version_1(const std::vector<pki::Certificate>& cas, const fs::path& path,
                        const Outcomes& outcomes, const Lineup& lineup, Diagnosis& out) {
  out.pass(Rule::DOC016);
  if (outcomes.all_ok()) return;
  for (const auto& ca : cas)
    if (ca.is_version_1())
      out.report(outcomes, {.rule = Rule::DOC016,
                            .message = fmt::format(
                                "{} of {} is a certificate of X.509 version 1, which {} does not "
                                "take as a CA",
                                name_of(path), ca.subject(), who_refuses(outcomes, lineup)),
                            .document = path});
}

void diagnose_versions(const LoadedFolder& folder, const Lineup& lineup, Diagnosis& out) {
  if (folder.identity_cas)
    diagnose_version_1(*folder.identity_cas, folder.paths.identity_ca,
                       measured(Variant::x509_v1_ca, lineup), lineup, out);
  if (folder.permissions_cas)
    diagnose_version_1(*folder.permissions_cas, folder.paths.permissions_ca,
                       measured(Variant::x509_v1_permissions_ca, lineup), lineup, out);
}

void diagnose_digests(const LoadedFolder& folder, const Lineup& lineup, Diagnosis& out) {
  // diagnose_chain reports SHA-1 below a CA, which ddssec refuses.
  if (folder.certificate && folder.certificate->signature_digest() != "SHA1")
    diagnose_digest(*folder.certificate, folder.paths.certificate, Variant::identity_sha512, lineup,
                    out);
  if (folder.identity_cas)
    for (const auto& ca : *folder.identity_cas)
      diagnose_digest(ca, folder.paths.identity_ca, Variant::identity_ca_sha512, lineup, out);
  if (folder.permissions_cas)
    for (const auto& ca : *folder.permissions_cas)
      diagnose_digest(ca, folder.paths.permissions_ca, Variant::permissions_ca_sha512, lineup, out);
}

void diagnose_pair(const LoadedFolder& folder, const Lineup& lineup, Diagnosis& out) {
  if (!folder.key || !folder.certificate) return;
  if (folder.key->check_fits(*folder.certificate)) return out.pass(Rule::DOC012);
  auto outcomes = measured(Variant::key_of_another, lineup);
  outcomes.ddssec = Outcome::fail;
  out.report(outcomes,
             {.rule = Rule::DOC012,
              .message = fmt::format("{} ({}) is not the private half of the key in {} ({} of {}); "
                                     "Cyclone DDS still starts and never authenticates",
                                     name_of(folder.paths.key), to_string(folder.key->algorithm()),
                                     name_of(folder.paths.certificate),
                                     to_string(folder.certificate->key_algorithm()),
                                     folder.certificate->subject()),
              .document = folder.paths.key});
}

bool is_twin(const pki::Certificate& one, const pki::Certificate& other) {
  return one.subject() == other.subject() && pki::key_digest(one) == pki::key_digest(other);
}

// The products that accept a file with a CA certificate that is not valid now. All do if a valid
// one of the same name and key is before it, as `ca renew` writes them. Stock products use the
// first one (measured).
Outcomes outcomes_of_dates(const pki::Certificate& ca, const std::vector<pki::Certificate>& cas,
                           WallTime now) {
  bool is_before = true;
  for (const auto& one : cas) {
    if (one == ca) is_before = false;
    if (!is_twin(one, ca) || !is_valid(one, now)) continue;
    return is_before ? Outcomes() : Outcomes{Outcome::fail, Outcome::fail, Outcome::ok};
  }
  return kAllFail;
}

void diagnose_dates(const LoadedFolder& folder, WallTime now, Diagnosis& out) {
  if (folder.certificate && is_valid(*folder.certificate, now)) out.pass(Rule::DOC021);
  if (folder.certificate && !is_valid(*folder.certificate, now))
    out.report(kAllFail,
               {.rule = Rule::DOC021,
                .message = dates_wrong(folder.paths.certificate, *folder.certificate, now),
                .document = folder.paths.certificate,
                .hint = hint_if_early(folder.certificate->not_before(), now)});
  const auto look = [&](const auto& cas, const fs::path& path) {
    if (!cas) return;
    out.pass(Rule::DOC022);
    for (const auto& ca : *cas) {
      const auto outcomes = is_valid(ca, now) ? Outcomes() : outcomes_of_dates(ca, *cas, now);
      if (outcomes.all_ok()) continue;
      out.report(outcomes, {.rule = Rule::DOC022,
                            .message = dates_wrong(path, ca, now),
                            .document = path,
                            .hint = hint_if_early(ca.not_before(), now)});
    }
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

// Returns one sentence that names the CA that issued and the CA that is configured.
std::string chain_broken(const LoadedFolder& folder, const Error& error) {
  const auto file = name_of(folder.paths.certificate);
  const auto ca_file = name_of(folder.paths.identity_ca);
  const auto& certificate = *folder.certificate;
  if (error.code() == Code::not_a_ca)
    return fmt::format("{} of {}: {} in {} does not say that it is a CA ({} expected)", file,
                       certificate.subject(), error.details().field, ca_file,
                       error.details().expected);
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

// The message for a path that only ddssec, or only ddssec and Fast DDS, can follow.
std::string needs_other_ca_file(const LoadedFolder& folder, const Lineup& lineup) {
  return fmt::format(
      "{} of {} was issued by \"{}\"; {} needs that CA, self-signed, as the first "
      "certificate of {}, and {} the whole path up to a self-signed CA; it holds {}",
      name_of(folder.paths.certificate), folder.certificate->subject(),
      folder.certificate->issuer(), name(Product::cyclonedds, lineup),
      name_of(folder.paths.identity_ca), name(Product::fastdds, lineup),
      subjects(*folder.identity_cas));
}

// Wrong dates have their own rule. So that they hide nothing, the rest is judged at a time when the
// certificate is valid.
WallTime time_to_judge(const LoadedFolder& folder, WallTime now) {
  const auto& certificate = *folder.certificate;
  const WallTime time = is_valid(certificate, now) ? now : certificate.not_before();
  WallTime otherwise = time;
  for (const auto& ca : *folder.identity_cas) {
    if (ca.subject() != certificate.issuer()) continue;
    if (is_valid(ca, time)) return time;
    otherwise = std::max(certificate.not_before(), ca.not_before());
  }
  return otherwise;
}

void diagnose_chain(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  if (!folder.certificate || !folder.identity_cas) return;
  const auto verifier = pki::ChainVerifier::make(*folder.identity_cas);
  const auto proof =
      verifier ? verifier->verify(*folder.certificate, time_to_judge(folder, settings.now))
               : Result<pki::ValidChain>(std::unexpected(verifier.error()));
  const auto outcomes = chain_outcomes(*folder.certificate, *folder.identity_cas, proof,
                                       WrongDates::reported_elsewhere, settings.lineup);
  if (outcomes.all_ok()) return out.pass(Rule::DOC020);
  const bool only_stock = outcomes.ddssec == Outcome::ok;
  out.report(outcomes, {.rule = Rule::DOC020,
                        .message = only_stock ? needs_other_ca_file(folder, settings.lineup)
                                              : chain_broken(folder, proof.error()),
                        .document = folder.paths.certificate});
}

std::string crl_wrong(const LoadedFolder& folder, const Error& error) {
  const auto file = name_of(folder.paths.crl);
  const auto& crls = *folder.crls;
  if (error.code() == Code::crl_missing)
    return fmt::format("{} holds no list of \"{}\", which issued the certificate; it holds {}",
                       file, folder.certificate->issuer(),
                       crls.empty() ? "none" : '"' + crls.front().issuer() + '"') +
           (!crls.empty() && crls.front().is_partial()
                ? ", and says that it is about a part of the CA's certificates "
                  "(issuingDistributionPoint)"
                : "");
  return fmt::format("{}: {}", file, error.message());
}

std::string own_list(const LoadedFolder& folder) {
  const auto file = name_of(folder.paths.crl);
  if (folder.crls->empty()) return fmt::format("there is no {} here", file);
  return fmt::format("{} here is list {}", file,
                     to_string(folder.crls->front().number().value_or(0)));
}

// No product reads the CA's own list: the participant starts, and its peers accept it until they
// get the list (measured). A revocation by the list of another key of the CA counts once that key
// is the only one.
void report_revoked(const LoadedFolder& folder, const CaList& newer, Diagnosis& out) {
  const auto& certificate = *folder.certificate;
  const bool counts = is_of_its_ca(newer.list, certificate, *folder.identity_cas);
  Finding finding{
      .rule = Rule::DOC024,
      .message = fmt::format(
          "{} of {} (serial {}) is revoked by list {} of the CA{}, {}; {}",
          name_of(folder.paths.certificate), certificate.subject(), certificate.serial(),
          to_string(newer.list.number().value_or(0)), counts ? "" : "'s successor",
          newer.file.string(),
          counts ? own_list(folder) + "; participants that do not have that list yet accept it"
                 : "participants accept it while the former CA is in their files"),
      .document = newer.file};
  if (counts) {
    finding.hint =
        "the revocation cannot be undone. If its holder is still to be trusted, issue the "
        "participant again in its folder, with a new key: ddssec identity issue --replace, for ROS "
        "2 ddssec keystore enclave --replace. If not, let the others refuse it: ddssec crl "
        "distribute --ca CA gives them the list, and leaves out this folder";
  } else {
    finding.hint =
        "if the overlap has not ended, end it now: ddssec ca rotate CA --role identity --end";
    finding.severity = Severity::warning;
  }
  out.report(counts ? Outcomes::all(Outcome::unsafe) : Outcomes(), std::move(finding));
}

// Checks the CA's own list, if it is beside the participant and newer than the participant's list.
void diagnose_ca_list(const LoadedFolder& folder, Diagnosis& out) {
  if (!folder.crls || !folder.certificate || !folder.identity_cas) return;
  const auto newer = newer_ca_list(folder.paths, *folder.identity_cas, *folder.crls);
  if (!newer) return;
  if (lists_certificate(newer->list, *folder.certificate))
    return report_revoked(folder, *newer, out);
  if (!folder.has_crl_file) return;  // diagnose_revocation reports it
  out.report({}, {.rule = Rule::DOC023,
                  .message = fmt::format("the CA has list {}, {}; {}",
                                         to_string(newer->list.number().value_or(0)),
                                         newer->file.string(), own_list(folder)),
                  .document = folder.paths.crl,
                  .hint = "put the CA's list into the participants' folders: ddssec crl distribute",
                  .severity = Severity::warning});
}

// Reports that the participants' lists are newer than the CA's, so that the next list of the CA
// would lose entries.
void diagnose_outdated_ca(const LoadedFolder& folder, Diagnosis& out) {
  if (!folder.crls || !folder.identity_cas) return;
  const auto outdated = outdated_ca_list(folder.paths, *folder.identity_cas, *folder.crls);
  if (!outdated) return;
  out.report({},
             {.rule = Rule::DOC023,
              .message = fmt::format(
                  "the CA has list {} only, {}; {}: the CA's folder came back from a backup, or "
                  "it is a copy",
                  to_string(outdated->list.number().value_or(0)), outdated->file.string(),
                  own_list(folder)),
              .document = outdated->file,
              .hint = fmt::format("ddssec crl new --ca CA --from {} makes a list that names "
                                  "what both name; then ddssec crl distribute",
                                  folder.paths.folder.string()),
              .severity = Severity::warning});
}

// Reports several keys of one CA. This is the state during an overlap of `ca rotate`, whose end may
// not have reached this folder.
void diagnose_former_ca(const Result<std::vector<pki::Certificate>>& cas, const fs::path& file,
                        std::string_view role, Diagnosis& out) {
  if (!cas || cas->empty()) return;
  const auto& own = cas->front();
  const bool has_other_key = std::ranges::any_of(*cas, [&](const auto& other) {
    return other.subject() == own.subject() && pki::key_digest(other) != pki::key_digest(own);
  });
  if (!has_other_key) return out.pass(Rule::DOC111);
  out.report({},
             {.rule = Rule::DOC111,
              .message = fmt::format("{} has CAs of the name \"{}\" with different keys: the "
                                     "participant accepts each of them",
                                     file.filename().string(), own.subject()),
              .document = file,
              .hint = fmt::format("nothing, as long as the overlap of ca rotate lasts (ddssec ca "
                                  "show CA); if it has ended: ddssec ca rotate CA --role {} "
                                  "--end gives this folder the CA that counts",
                                  role)});
}

// Products read different lists of a CA that has several.
void diagnose_several_lists(const LoadedFolder& folder, Diagnosis& out) {
  if (!folder.crls) return;
  const auto& lists = *folder.crls;
  for (const auto& list : lists) {
    const auto count = std::ranges::count_if(
        lists, [&](const auto& one) { return one.may_be_from_same_ca(list); });
    if (count < 2) continue;
    return out.report(
        {}, {.rule = Rule::DOC023,
             .message = fmt::format(
                 "{} holds {} lists of \"{}\"; Cyclone DDS and Fast DDS read the first list of the "
                 "file only, which is list {} of \"{}\", and ddssec's plugins the newest",
                 name_of(folder.paths.crl), count, list.issuer(),
                 to_string(lists.front().number().value_or(0)), lists.front().issuer()),
             .document = folder.paths.crl,
             .hint = "keep the newest alone: ddssec crl distribute --ca CA",
             .severity = Severity::warning});
  }
}

// The certificate's status according to the lists that the product reads.
Status status_by_lists(const LoadedFolder& folder, Product product, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, folder.chain(product));
  const auto proof = verifier.verify(*folder.certificate, now);
  return proof ? Status() : std::unexpected(proof.error());
}

bool is_revoked(const Status& status) {
  return !status && status.error().code() == Code::certificate_revoked;
}

bool is_about_the_list(const Status& status) {
  return !status && Code::crl_malformed <= status.error().code() &&
         status.error().code() <= Code::crl_signature_invalid;
}

Outcomes failing(bool stock, bool ours) {
  auto out = Outcomes::all(stock ? Outcome::fail : Outcome::ok);
  out.ddssec = ours ? Outcome::fail : Outcome::ok;
  return out;
}

void diagnose_crl_form(const LoadedFolder& folder, const Lineup& lineup, Diagnosis& out) {
  const auto outcomes = measured(Variant::crl_der, lineup);
  if (!folder.is_crl_der || outcomes.all_ok()) return;
  out.report(outcomes, {.rule = Rule::DOC023,
                        .message = fmt::format("{} is DER, and stock products read PEM text only",
                                               name_of(folder.paths.crl)),
                        .document = folder.paths.crl,
                        .hint = "write it as PEM: openssl crl -inform DER -in FILE -out crl.pem"});
}

// Up to some patch levels OpenSSL takes a delta list for a complete one. Stock products then start
// with it and accept certificates that only the complete list revokes (measured with 3.0.19). The
// OpenSSL of this machine decides here as it does for them.
void diagnose_delta_list(const LoadedFolder& folder, WallTime now, Diagnosis& out) {
  const auto stock = folder.certificate && folder.identity_cas
                         ? status_by_lists(folder, Product::cyclonedds, now)
                         : Status();
  const auto outcome = stock ? Outcome::unsafe : Outcome::fail;
  const auto why = stock ? std::string(
                               "OpenSSL, and so stock products here, take it for a complete "
                               "list, and believe certificates that only that one names")
                         : stock.error().message();
  out.report({.cyclonedds = outcome, .fastdds = outcome, .ddssec = Outcome::fail},
             {.rule = Rule::DOC023,
              .message = fmt::format("{}: {}; {}", name_of(folder.paths.crl),
                                     folder.crls.error().message(), why),
              .document = folder.paths.crl,
              .hint = folder.crls.error().hint()});
}

void diagnose_revocation(const LoadedFolder& folder, WallTime now, const Lineup& lineup,
                         Diagnosis& out) {
  if (!folder.has_crl_file && !folder.is_empty())
    out.report({},
               {.rule = Rule::DOC023,
                .message = fmt::format("there is no {}: a revoked certificate still counts here",
                                       name_of(folder.paths.crl)),
                .document = folder.paths.folder,
                .hint = "put the CA's list there: ddssec crl distribute --ca CA; without a "
                        "list of it, ddssec crl new --ca CA makes one",
                .severity = Severity::warning});
  if (!folder.crls_with_deltas.empty()) return diagnose_delta_list(folder, now, out);
  if (!folder.has_crl_file || !folder.crls || !folder.certificate || !folder.identity_cas) return;
  diagnose_crl_form(folder, lineup, out);
  if (!folder.chain()) return;  // diagnose_chain reports it
  const auto ours = status_by_lists(folder, Product::ddssec, now);
  const auto stock = status_by_lists(folder, Product::cyclonedds, now);
  const auto revoked = failing(is_revoked(stock), is_revoked(ours));
  const auto unusable = failing(is_about_the_list(stock), is_about_the_list(ours));
  if (revoked.all_ok()) out.pass(Rule::DOC024);
  if (unusable.all_ok()) out.pass(Rule::DOC023);
  if (!revoked.all_ok())
    out.report(revoked, {.rule = Rule::DOC024,
                         .message = fmt::format(
                             "{} names serial {}, which is {} in {}: it was revoked",
                             name_of(folder.paths.crl), folder.certificate->serial(),
                             folder.certificate->subject(), name_of(folder.paths.certificate)),
                         .document = folder.paths.crl});
  if (unusable.all_ok()) return;
  const auto& error = is_about_the_list(ours) ? ours.error() : stock.error();
  out.report(unusable, {.rule = Rule::DOC023,
                        .message = crl_wrong(folder, error),
                        .document = folder.paths.crl,
                        .hint = error.code() == Code::crl_not_yet_valid ? clock_hint(now) : ""});
}

}  // namespace

void diagnose_identity(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  diagnose_key_types(folder, settings.lineup, out);
  diagnose_digests(folder, settings.lineup, out);
  diagnose_versions(folder, settings.lineup, out);
  diagnose_pair(folder, settings.lineup, out);
  diagnose_chain(folder, settings, out);
  diagnose_dates(folder, settings.now, out);
  diagnose_revocation(folder, settings.now, settings.lineup, out);
  diagnose_several_lists(folder, out);
  diagnose_ca_list(folder, out);
  diagnose_outdated_ca(folder, out);
  diagnose_former_ca(folder.identity_cas, folder.paths.identity_ca, "identity", out);
  diagnose_former_ca(folder.permissions_cas, folder.paths.permissions_ca, "permissions", out);
}

}  // namespace ddssec::governance::doctor
