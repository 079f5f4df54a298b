#include "plugins/authentication/identity_watch.hpp"

#include "base/rollback.hpp"
#include "pki/certificate_source.hpp"
#include "plugins/authentication/document_errors.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

namespace property = spi::property;

Result<Bytes> load_octets(std::string_view uri) {
  return pki::load_certificates(uri, property::kIdentityCertificate, pki::kMaxCertificateOctets);
}

Result<pki::PrivateKey> load_key(std::string_view uri, const OwnPassphrase& passphrase) {
  constexpr auto kName = property::kPrivateKey;
  return with_property(pki::PrivateKey::load(uri, kName, passphrase.get()), kName);
}

std::string uri_of(const std::string& path) { return path.empty() ? "" : "file:" + path; }

std::string path_in(const spi::PropertyList& properties, std::string_view name) {
  const auto uri = spi::property_value(properties, name);
  return file_named_by(absolute_uri(uri)).value_or("");
}

}  // namespace

Result<pki::Certificate> load_identity_certificate(const spi::PropertyList& properties) {
  constexpr auto kName = property::kIdentityCertificate;
  DDSSEC_ASSIGN_OR_RETURN(const Bytes octets, load_octets(spi::property_value(properties, kName)));
  return with_property(pki::Certificate::from_pem(octets), kName);
}

Result<pki::PrivateKey> load_identity_key(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto passphrase, own_passphrase(properties));
  return load_key(spi::property_value(properties, property::kPrivateKey), passphrase);
}

Result<OwnPassphrase> own_passphrase(const spi::PropertyList& properties) {
  const auto password = spi::property_value(properties, property::kPassword);
  if (password.empty()) return nullptr;
  if (password.size() > pki::Passphrase::capacity)
    return fail(Code::invalid_property,
                {.document = std::string(property::kPassword),
                 .expected = "at most " + std::to_string(pki::Passphrase::capacity) + " octets",
                 .found = std::to_string(password.size())});
  DDSSEC_ASSIGN_OR_RETURN(auto passphrase, pki::Passphrase::copy_of(as_bytes(password)));
  return std::make_shared<const pki::Passphrase>(std::move(passphrase));
}

Result<IdentityWatch> IdentityWatch::of(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto interval, spi::files_poll_interval(properties));
  IdentityWatch out(path_in(properties, property::kIdentityCertificate),
                    path_in(properties, property::kPrivateKey), interval);
  if (!out.key_path_.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(out.passphrase_, own_passphrase(properties));
  }
  return out;
}

IdentityWatch::IdentityWatch(std::string path, std::string key_path, std::chrono::seconds interval)
    : path_(std::move(path)),
      key_path_(path_.empty() ? "" : std::move(key_path)),
      certificate_(uri_of(path_), interval),
      key_(uri_of(key_path_), interval) {}

const std::string& IdentityWatch::path_of(const Error& error) const {
  const bool is_about_key = error.details().document == property::kPrivateKey;
  return is_about_key && !key_path_.empty() ? key_path_ : path_;
}

Result<std::optional<IdentityWatch::FoundIdentity>> IdentityWatch::poll(
    std::chrono::nanoseconds now, const FoundIdentity& in_force, const Accept& accept) {
  const bool certificate_may = certificate_.may_have_changed(now);
  const bool key_may = key_.may_have_changed(now);
  if (!certificate_may && !key_may) return std::nullopt;
  Rollback again([&] {
    certificate_.force_change();
    key_.force_change();
  });
  Sha256Digest content{};
  auto found = judge(in_force, accept, content);
  if (found) {
    refusals_.clear();
    again.release();
    return found;
  }
  if (!refusals_.note_refusal(found.error().code(), content)) return std::nullopt;
  auto refused =
      renewal_refused_error(Code::identity_renewal_refused, found.error(), path_of(found.error()),
                            "the certificate read before stays in force");
  if (found.error().code() != Code::file_not_found)
    return std::unexpected(refusals_.note(std::move(refused)));
  auto details = refused.details();
  details.hint =
      "put the file back; without a copy of the key: ddssec identity issue NAME --ca CA "
      "-o FOLDER --replace, and start the participant again";
  return std::unexpected(refusals_.note(Error(Code::identity_renewal_refused, std::move(details))));
}

Result<pki::PrivateKey> IdentityWatch::key(const FoundIdentity& in_force) const {
  if (key_path_.empty()) return in_force.key;
  return load_key(uri_of(key_path_), passphrase_);
}

Result<IdentityWatch::FoundIdentity> IdentityWatch::read(const FoundIdentity& in_force) const {
  if (path_.empty()) return in_force;
  DDSSEC_ASSIGN_OR_RETURN(const Bytes octets, load_octets(uri_of(path_)));
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, with_property(pki::Certificate::from_pem(octets),
                                                          property::kIdentityCertificate));
  DDSSEC_ASSIGN_OR_RETURN(auto own_key, key(in_force));
  return FoundIdentity{std::move(certificate), std::move(own_key)};
}

Result<std::optional<IdentityWatch::FoundIdentity>> IdentityWatch::judge(
    const FoundIdentity& in_force, const Accept& accept, Sha256Digest& content) const {
  DDSSEC_ASSIGN_OR_RETURN(const Bytes octets, load_octets(uri_of(path_)));
  content = sha256(octets);
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, with_property(pki::Certificate::from_pem(octets),
                                                          property::kIdentityCertificate));
  if (certificate == in_force.certificate && key_path_.empty()) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(auto own_key, key(in_force));
  if (certificate == in_force.certificate) {
    // The file may hold the key of a certificate that has not come yet, or the old key in another
    // form.
    DDSSEC_RETURN_IF_ERROR(with_property(own_key.check_fits(certificate), property::kPrivateKey));
    return std::nullopt;
  }
  FoundIdentity found{std::move(certificate), std::move(own_key)};
  DDSSEC_RETURN_IF_ERROR(accept(found));
  return found;
}

}  // namespace ddssec::authentication
