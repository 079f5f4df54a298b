#include "plugins/authentication/identity_files.hpp"

#include <algorithm>
#include <filesystem>
#include <string>

#include "pki/certificate_source.hpp"
#include "plugins/authentication/document_errors.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

namespace property = spi::property;

// The largest number of certificates in a trusted_ca_dir, as in Cyclone DDS.
constexpr std::size_t kMaxTrustedCas = 100;

// Adds to an error the files that the properties name, unless they are in it already, so that the
// folder with the wrong file can be found. A value that is in the property itself is never shown.
Error with_file_names(const Error& error, const spi::PropertyList& properties,
                      std::initializer_list<std::string_view> names) {
  auto details = error.details();
  for (const auto name : names) {
    const auto value = spi::property_value(properties, name);
    const auto place =
        names_token(value) ? std::optional(without_pin(value)) : file_named_by(value);
    if (!place || details.found.contains(*place) || details.note.contains(*place)) continue;
    details.note += (details.note.empty() ? "" : "; ") + std::string(name) + " is " + *place;
  }
  return {error.code(), std::move(details)};
}

template <class T>
Result<T> with_file_names(Result<T> result, const spi::PropertyList& properties,
                          std::initializer_list<std::string_view> names) {
  if (result) return result;
  return std::unexpected(with_file_names(result.error(), properties, names));
}

Result<std::vector<pki::Certificate>> load_bundle(std::string_view uri, std::string_view name) {
  DDSSEC_ASSIGN_OR_RETURN(const Bytes octets,
                          pki::load_certificates(uri, name, pki::kMaxBundleOctets));
  return with_property(pki::Certificate::bundle_from_pem(octets), name);
}

// Loads the certificate authorities among the readable PEM files of a folder. Other files are
// skipped.
Result<std::vector<pki::Certificate>> load_folder(std::string_view value) {
  constexpr auto kName = property::kTrustedCaDir;
  // A plain path is accepted, too.
  const auto folder = file_named_by(value).value_or(std::string(value));
  std::error_code error;
  std::filesystem::directory_iterator entries(folder, error);
  std::vector<std::string> paths;
  for (; !error && entries != std::filesystem::directory_iterator(); entries.increment(error))
    paths.push_back(entries->path().string());
  if (error)
    return fail(Code::trusted_ca_dir_unreadable,
                {.document = std::string(kName), .found = folder, .note = error.message()});
  std::ranges::sort(paths);
  std::vector<pki::Certificate> found;
  for (const auto& path : paths) {
    const auto bundle = load_bundle("file:" + path, kName);
    if (!bundle) continue;
    std::ranges::copy_if(*bundle, std::back_inserter(found), &pki::Certificate::is_ca);
    if (found.size() > kMaxTrustedCas)
      return fail(Code::trusted_ca_dir_too_many,
                  {.document = std::string(kName),
                   .expected = "at most " + std::to_string(kMaxTrustedCas),
                   .found = folder});
  }
  return found;
}

Result<std::vector<pki::Certificate>> load_anchors(const spi::PropertyList& properties) {
  constexpr auto kName = property::kIdentityCa;
  return load_bundle(spi::property_value(properties, kName), kName);
}

// Loads the trusted_ca_dir, if one is named. Our own CA must be in it. Otherwise we would trust
// peers that do not trust us.
Result<std::shared_ptr<const TrustStore>> load_peer_trust(
    const spi::PropertyList& properties, const RevocationLists& lists,
    const std::shared_ptr<const TrustStore>& own, TrustStores& stores) {
  constexpr auto kName = property::kTrustedCaDir;
  const auto folder = spi::property_value(properties, kName);
  if (folder.empty()) return own;
  if (!lists.in_force().empty())
    return fail(Code::trusted_ca_dir_with_crl, {.document = std::string(kName)});
  DDSSEC_ASSIGN_OR_RETURN(auto anchors, load_folder(folder));
  for (const auto& ca : own->anchors())
    if (std::ranges::find(anchors, ca) == anchors.end())
      return fail(
          Code::own_ca_not_trusted,
          {.document = std::string(kName), .expected = ca.subject(), .found = std::string(folder)});
  return with_property(stores.open(std::move(anchors), {}), kName);
}

Result<pki::AuthorityWatch> watch_authorities(const spi::PropertyList& properties) {
  constexpr auto kName = property::kIdentityCa;
  DDSSEC_ASSIGN_OR_RETURN(const auto interval, spi::files_poll_interval(properties));
  const auto uri = spi::property_value(properties, kName);
  return pki::AuthorityWatch({.uri = std::string(uri),
                              .name = std::string(kName),
                              .max_octets = 0,
                              .refused = Code::identity_ca_renewal_refused,
                              .stays = "the CAs read before stay in force"},
                             interval);
}

Status check_belongs(const pki::PrivateKey& key, const pki::Certificate& certificate) {
  return with_property(key.check_fits(certificate), property::kPrivateKey);
}

}  // namespace

Result<IdentityFiles> IdentityFiles::load(const spi::PropertyList& properties, TrustStores& stores,
                                          WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto warn_before_end, spi::warning_days(properties));
  DDSSEC_ASSIGN_OR_RETURN(const auto ocsp_policy, spi::ocsp_policy(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto ocsp_response, OwnOcspResponse::of(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto listed, ListedRenewals::of(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto watch, IdentityWatch::of(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto authorities, watch_authorities(properties));
  constexpr auto kCa = property::kIdentityCa, kKey = property::kPrivateKey;
  constexpr auto kOwn = property::kIdentityCertificate;
  DDSSEC_ASSIGN_OR_RETURN(auto anchors,
                          with_file_names(load_anchors(properties), properties, {kCa}));
  DDSSEC_ASSIGN_OR_RETURN(auto lists, RevocationLists::load(properties, anchors, now));
  DDSSEC_ASSIGN_OR_RETURN(
      auto own,
      with_file_names(with_property(stores.open(std::move(anchors), lists.in_force()), kCa),
                      properties, {kCa}));
  DDSSEC_ASSIGN_OR_RETURN(auto peers, load_peer_trust(properties, lists, own, stores));
  DDSSEC_ASSIGN_OR_RETURN(
      auto certificate, with_file_names(load_identity_certificate(properties), properties, {kOwn}));
  DDSSEC_ASSIGN_OR_RETURN(auto key,
                          with_file_names(load_identity_key(properties), properties, {kKey}));
  DDSSEC_RETURN_IF_ERROR(
      with_file_names(check_belongs(key, certificate), properties, {kKey, kOwn}));
  DDSSEC_RETURN_IF_ERROR(
      with_file_names(with_property(own->verify(certificate, now), kOwn), properties, {kOwn, kCa}));
  DDSSEC_RETURN_IF_ERROR(ocsp_response.read_first({certificate, *own, now}));
  return IdentityFiles{
      .certificate = std::move(certificate),
      .key = std::move(key),
      .watch = std::move(watch),
      .authorities = std::move(authorities),
      .revocation_lists = std::move(lists),
      .own_trust = std::move(own),
      .peer_trust = std::move(peers),
      .has_trusted_folder = !spi::property_value(properties, property::kTrustedCaDir).empty(),
      .warn_before_end = std::move(warn_before_end),
      .ocsp_policy = ocsp_policy,
      .ocsp_response = std::move(ocsp_response),
      .listed = std::move(listed)};
}

}  // namespace ddssec::authentication
