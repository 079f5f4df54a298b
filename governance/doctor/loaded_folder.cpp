#include "governance/doctor/loaded_folder.hpp"

#include "governance/doctor/lenient_text.hpp"
#include "governance/read.hpp"
#include "pki/certificate_source.hpp"
#include "pki/login_ban.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

std::string uri(const fs::path& path) { return "file://" + path.string(); }

std::unexpected<Error> file_error(const Error& error, const fs::path& path) {
  return std::unexpected(pki::file_error(error, path));
}

template <class T>
Result<T> with_file(Result<T> result, const fs::path& path) {
  if (result) return result;
  return file_error(result.error(), path);
}

template <class Parse>
auto load_with(const fs::path& path, std::size_t max_octets, Parse parse)
    -> decltype(parse(BytesView())) {
  const auto uri = pki::uri_of(path);
  if (!uri) return file_error(uri.error(), path);
  const auto octets = pki::load_certificates(*uri, path.string(), max_octets);
  if (!octets) return file_error(octets.error(), path);
  return with_file(parse(*octets), path);
}

Result<pki::PrivateKey> load_key(const fs::path& path) {
  DDSSEC_ASSIGN_OR_RETURN(const auto uri, with_file(pki::uri_of(path), path));
  return with_file(pki::PrivateKey::load(uri, path.string()), path);
}

using pki::may_exist;

Result<std::vector<pki::Crl>> load_crls(const fs::path& path) {
  if (!may_exist(path)) return std::vector<pki::Crl>();
  auto lists = load_with(path, pki::kMaxDocumentOctets, &pki::Crl::all_from);
  if (lists && lists->empty()) return fail(Code::crl_file_empty, {.document = path.string()});
  return lists;
}

// Reads the file with its delta lists. Empty unless ddssec refuses it because of a delta list.
// Stock products read PEM only.
std::vector<pki::Crl> load_with_deltas(const fs::path& path,
                                       const Result<std::vector<pki::Crl>>& crls, bool is_der) {
  if (crls || crls.error().code() != Code::crl_is_delta || is_der) return {};
  return load_with(path, pki::kMaxDocumentOctets, &pki::Crl::all_with_deltas_from)
      .value_or(std::vector<pki::Crl>());
}

// A list in DER begins with a SEQUENCE.
bool begins_like_der(const fs::path& path) {
  const auto octets = ddssec::load_uri(uri(path), "", pki::kMaxDocumentOctets);
  return octets && octets->front() == 0x30;
}

using Certificates = Result<std::vector<pki::Certificate>>;

// The certificates and the content of the permissions CA file.
struct Trust {
  Certificates cas;
  Bytes file;
};

// The text is read even if its signature is refused, so that other faults in it can be reported.
// Such a text is used for reports only.
template <class Model>
LoadedDocument<Model> load_document(const fs::path& path, const Trust& trust,
                                    Result<Model> (*read)(BytesView, int), WallTime now) {
  LoadedDocument<Model> out;
  auto file = pki::load_uri(uri(path), path.string(), pki::kMaxDocumentOctets);
  if (!file) {
    out.readable = file_error(file.error(), path);
    out.parsed = out.readable;
    return out;
  }
  out.file = *std::move(file);
  out.form = pki::examine_document(out.file);
  const auto& [cas, ca_file] = trust;
  out.cyclonedds_verdict = verify_signature_as(Product::cyclonedds, out.file, cas, ca_file, now);
  out.fastdds_verdict = verify_signature_as(Product::fastdds, out.file, cas, ca_file, now);
  out.our_verdict = verify_signature_as(Product::ddssec, out.file, cas, ca_file, now);
  auto model = read(out.form.unverified_text, out.form.first_line);
  if (!model) {
    out.parsed = file_error(model.error(), path);
    auto lenient = lenient_text(out.form.unverified_text);
    out.left_out = std::move(lenient.left_out);
    out.has_joined_values = lenient.has_joined_values;
    out.is_refused_by_fastdds = lenient.is_refused_by_fastdds;
    if (!out.left_out.empty() || out.has_joined_values || out.is_refused_by_fastdds) {
      model = read(lenient.text, out.form.first_line);
      if (!model) out.parsed_without = file_error(model.error(), path);
    }
  }
  if (model) out.model = std::make_shared<const Model>(*std::move(model));
  return out;
}

// Returns the verdict of a stock product. OpenSSL has one reason for a changed document and for one
// that another CA signed; ddssec's verifier tells them apart.
Status with_signer_named(Status verdict, BytesView file, std::vector<pki::Certificate> cas,
                         WallTime now) {
  if (verdict || verdict.error().code() != Code::smime_signature_invalid) return verdict;
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, pki::DocumentVerifier::make(std::move(cas)));
  const auto proof = verifier.verify(file, now);
  const bool is_foreign = !proof && proof.error().code() == Code::smime_signer_not_permissions_ca;
  return is_foreign ? std::unexpected(proof.error()) : verdict;
}

}  // namespace

Status verify_signature_as(Product judge, BytesView file, const Certificates& cas,
                           BytesView ca_file, WallTime now) {
  if (!cas && cas.error().code() == Code::key_not_allowed && judge != Product::ddssec)
    return pki::verify_as_stock_products(
        file, ca_file, judge == Product::cyclonedds ? 1 : pki::kMaxCertificatesInBundle, now);
  if (!cas) return std::unexpected(cas.error());
  if (judge != Product::ddssec) {
    const auto read = judge == Product::cyclonedds ? std::vector{cas->front()} : *cas;
    return with_signer_named(pki::verify_as_stock_products(file, read, now), file, read, now);
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, pki::DocumentVerifier::make(*cas));
  const auto proof = verifier.verify(file, now);
  return proof ? Status() : std::unexpected(proof.error());
}

std::size_t handshake_octets(const LoadedFolder& folder) {
  return folder.permissions.file.size() +
         (folder.certificate ? folder.certificate->pem().size() : 0);
}

bool LoadedFolder::is_empty() const {
  return !may_exist(paths.identity_ca) && !may_exist(paths.certificate) && !may_exist(paths.key) &&
         !may_exist(paths.permissions_ca) && !may_exist(paths.governance) &&
         !may_exist(paths.permissions);
}

Result<pki::ChainVerifier> LoadedFolder::chain(Product judge) const {
  if (!identity_cas) return std::unexpected(identity_cas.error());
  if (!has_usable_lists(judge)) return std::unexpected(crls.error());
  auto lists = crls ? *crls : crls_with_deltas;
  if (judge != Product::ddssec && lists.size() > 1) lists.erase(lists.begin() + 1, lists.end());
  return with_file(pki::ChainVerifier::make(*identity_cas, std::move(lists)), paths.identity_ca);
}

LoadedFolder load_folder(const pki::ParticipantFolder& paths, WallTime now) {
  const pki::LoginBan no_logins(pki::may_be_changed_by_others(paths));
  const auto bundle = [](const fs::path& path) {
    return load_with(path, pki::kMaxBundleOctets, &pki::Certificate::bundle_from_pem);
  };
  Trust trust{
      bundle(paths.permissions_ca),
      ddssec::load_uri(uri(paths.permissions_ca), "", pki::kMaxBundleOctets).value_or(Bytes())};
  auto governance = load_document(paths.governance, trust, &read_governance, now);
  auto permissions = load_document(paths.permissions, trust, &read_permissions, now);
  auto crls = load_crls(paths.crl);
  const bool is_crl_der = begins_like_der(paths.crl);
  auto crls_with_deltas = load_with_deltas(paths.crl, crls, is_crl_der);
  return {.paths = paths,
          .identity_cas = bundle(paths.identity_ca),
          .certificate =
              load_with(paths.certificate, pki::kMaxCertificateOctets, &pki::Certificate::from_pem),
          .key = load_key(paths.key),
          .permissions_cas = std::move(trust.cas),
          .permissions_ca_file = std::move(trust.file),
          .crls = std::move(crls),
          .crls_with_deltas = std::move(crls_with_deltas),
          .has_crl_file = may_exist(paths.crl),
          .is_crl_der = is_crl_der,
          .governance = std::move(governance),
          .permissions = std::move(permissions)};
}

}  // namespace ddssec::governance::doctor
