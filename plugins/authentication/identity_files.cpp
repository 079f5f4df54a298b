#include "plugins/authentication/identity_files.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include "pki/certificate_source.hpp"
#include "pki/withdrawn_authorities.hpp"
#include "plugins/authentication/document_errors.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

namespace property = spi::property;

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

Result<std::vector<pki::Certificate>> load_anchors(const spi::PropertyList& properties) {
  constexpr auto kName = property::kIdentityCa;
  return load_bundle(spi::property_value(properties, kName), kName);
}

// Returns the trusted_ca_dir, not read yet; nothing if none is named.
Result<std::optional<TrustedFolder>> find_trusted_folder(const spi::PropertyList& properties) {
  const auto folder = spi::property_value(properties, property::kTrustedCaDir);
  if (folder.empty()) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(const auto interval, spi::files_poll_interval(properties));
  return TrustedFolder(folder, interval);
}

// Loads the CAs of the trusted_ca_dir, if one is named.
Result<std::shared_ptr<const TrustStore>> load_peer_trust(
    std::optional<TrustedFolder>& folder, const RevocationLists& lists,
    const std::shared_ptr<const TrustStore>& own, TrustStores& stores) {
  constexpr auto kName = property::kTrustedCaDir;
  if (!folder) return own;
  if (!lists.in_force().empty())
    return fail(Code::trusted_ca_dir_with_crl, {.document = std::string(kName)});
  DDSSEC_ASSIGN_OR_RETURN(auto anchors, folder->read_first());
  DDSSEC_RETURN_IF_ERROR(check_in_trusted_folder(own->anchors(), anchors, folder->path()));
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

Status check_in_trusted_folder(const std::vector<pki::Certificate>& own,
                               const std::vector<pki::Certificate>& trusted,
                               const std::string& folder) {
  const auto missing = pki::leaving(own, trusted);
  if (missing.empty()) return {};
  return fail(Code::own_ca_not_trusted, {.document = std::string(property::kTrustedCaDir),
                                         .expected = missing.front().subject(),
                                         .found = folder});
}

Result<IdentityFiles> IdentityFiles::load(const spi::PropertyList& properties, TrustStores& stores,
                                          WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto warn_before_end, spi::warning_days(properties));
  DDSSEC_ASSIGN_OR_RETURN(const auto ocsp_policy, spi::ocsp_policy(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto ocsp_response, OwnOcspResponse::of(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto listed, ListedRenewals::of(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto watch, IdentityWatch::of(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto authorities, watch_authorities(properties));
  DDSSEC_ASSIGN_OR_RETURN(auto folder, find_trusted_folder(properties));
  constexpr auto kCa = property::kIdentityCa, kKey = property::kPrivateKey;
  constexpr auto kOwn = property::kIdentityCertificate;
  DDSSEC_ASSIGN_OR_RETURN(auto anchors,
                          with_file_names(load_anchors(properties), properties, {kCa}));
  DDSSEC_ASSIGN_OR_RETURN(auto lists, RevocationLists::load(properties, anchors, now));
  DDSSEC_ASSIGN_OR_RETURN(
      auto own,
      with_file_names(with_property(stores.open(std::move(anchors), lists.in_force()), kCa),
                      properties, {kCa}));
  DDSSEC_ASSIGN_OR_RETURN(auto peers, load_peer_trust(folder, lists, own, stores));
  DDSSEC_ASSIGN_OR_RETURN(
      auto certificate, with_file_names(load_identity_certificate(properties), properties, {kOwn}));
  DDSSEC_ASSIGN_OR_RETURN(auto key,
                          with_file_names(load_identity_key(properties), properties, {kKey}));
  DDSSEC_RETURN_IF_ERROR(
      with_file_names(check_belongs(key, certificate), properties, {kKey, kOwn}));
  DDSSEC_RETURN_IF_ERROR(
      with_file_names(with_property(own->verify(certificate, now), kOwn), properties, {kOwn, kCa}));
  DDSSEC_RETURN_IF_ERROR(ocsp_response.read_first({certificate, *own, now}));
  return IdentityFiles{.certificate = std::move(certificate),
                       .key = std::move(key),
                       .watch = std::move(watch),
                       .authorities = std::move(authorities),
                       .revocation_lists = std::move(lists),
                       .own_trust = std::move(own),
                       .peer_trust = std::move(peers),
                       .trusted_folder = std::move(folder),
                       .warn_before_end = std::move(warn_before_end),
                       .ocsp_policy = ocsp_policy,
                       .ocsp_response = std::move(ocsp_response),
                       .listed = std::move(listed)};
}

}  // namespace ddssec::authentication
