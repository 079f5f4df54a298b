#include "plugins/authentication/own_identity.hpp"

#include <algorithm>
#include <string>

#include "base/time_left.hpp"
#include "pki/document_parts.hpp"
#include "pki/subject_name.hpp"
#include "plugins/authentication/adjusted_guid.hpp"
#include "plugins/authentication/document_errors.hpp"
#include "plugins/authentication/identity_token.hpp"
#include "plugins/authentication/identity_watch.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

namespace property = spi::property;

}  // namespace

OwnIdentity::OwnIdentity(IdentityFiles files, const Guid& candidate)
    : guid_(adjusted_guid(files.certificate.subject_digest(), candidate)),
      watch_(std::move(files.watch)),
      authorities_(std::move(files.authorities)),
      trusted_folder_(std::move(files.trusted_folder)),
      revocation_lists_(std::move(files.revocation_lists)),
      ocsp_policy_(files.ocsp_policy),
      ocsp_response_(std::move(files.ocsp_response)),
      listed_(std::move(files.listed)),
      certificate_warning_(files.warn_before_end),
      list_warning_(files.warn_before_end),
      own_trust_(std::move(files.own_trust)),
      peer_trust_(std::move(files.peer_trust)),
      presented_(std::make_shared<const PresentedDocuments>(
          PresentedDocuments{std::move(files.certificate), std::move(files.key), Bytes(1)})),
      ocsp_in_force_(ocsp_response_.in_force()) {}

spi::Token OwnIdentity::identity_token(spi::CipherMask ciphers) const {
  const auto trust = own_trust();
  const auto own = certificate();
  const auto& anchors = trust->anchors();
  const auto issuer =
      std::ranges::find_if(anchors, [&](const auto& ca) { return own.is_issued_by(ca); });
  return write_identity_token(own, issuer == anchors.end() ? anchors.front() : *issuer, ciphers);
}

Result<pki::ValidChain> OwnIdentity::verify(const pki::Certificate& own, WallTime now) const {
  return with_property(own_trust()->verify(own, now), property::kIdentityCertificate);
}

std::vector<Error> OwnIdentity::ends_soon(WallTime now) {
  // An invalid chain is reported by another error.
  const auto chain = verify(now);
  if (!chain) return {};
  const std::scoped_lock lock(renewal_mutex_);
  std::vector<Error> out;
  const auto end = chain->not_after();
  if (certificate_warning_.is_due(chain->certificate().not_before(), end, now))
    out.emplace_back(Code::identity_ends_soon, ErrorDetails{.document = chain->first_to_expire(),
                                                            .field = "notAfter",
                                                            .found = in_time(end, now)});
  const auto* const list = revocation_lists_.first_to_end(chain->crl_next_update());
  if (list != nullptr && list_warning_.is_due(list->this_update(), *list->next_update(), now))
    out.emplace_back(Code::crl_ends_soon,
                     ErrorDetails{.document = revocation_lists_.path(),
                                  .field = "nextUpdate",
                                  .found = in_time(*list->next_update(), now)});
  return out;
}

std::optional<pki::ValidChain> OwnIdentity::listed_after(const pki::Certificate& seen,
                                                         WallTime now) const {
  return listed_->after({seen, seen}, *own_trust(), now).chain;
}

std::shared_ptr<const TrustStore> OwnIdentity::own_trust() const {
  const std::scoped_lock lock(mutex_);
  return own_trust_;
}

std::shared_ptr<const TrustStore> OwnIdentity::peer_trust() const {
  const std::scoped_lock lock(mutex_);
  return peer_trust_;
}

std::string OwnIdentity::revocation_list_path() const {
  const std::scoped_lock lock(renewal_mutex_);
  return revocation_lists_.path();
}

std::string OwnIdentity::revocation_lists() const {
  const std::scoped_lock lock(renewal_mutex_);
  return revocation_lists_.description();
}

Result<bool> OwnIdentity::renew_revocation_lists(TrustStores& stores, const Clock& clock) {
  const std::scoped_lock lock(renewal_mutex_);
  const auto trust = own_trust();
  return revocation_lists_.poll(clock, trust->anchors(), [&](const std::vector<pki::Crl>& lists) {
    return adopt_lists(lists, stores, clock.calendar_seconds());
  });
}

// A new store is opened, because it does not remember which peers the former one trusted.
Status OwnIdentity::adopt_lists(const std::vector<pki::Crl>& lists, TrustStores& stores,
                                WallTime now) {
  const auto former = own_trust();
  if (trusted_folder_) return fail(Code::trusted_ca_dir_with_crl);
  DDSSEC_RETURN_IF_ERROR(
      check_renewal(lists, revocation_lists_.in_force(), former->anchors(), now));
  DDSSEC_ASSIGN_OR_RETURN(auto renewed, stores.open(former->anchors(), lists));
  const auto own = renewed->verify(certificate(), now);
  if (!own && own.error().code() != Code::certificate_revoked) {
    // If the lists in force have the same fault, for example one that has ended, the new ones are
    // not worse.
    const auto before = former->verify(certificate(), now);
    if (before || before.error().code() != own.error().code()) return std::unexpected(own.error());
  }
  const std::scoped_lock lock(mutex_);
  own_trust_ = peer_trust_ = std::move(renewed);
  ++renewals_;
  listed_->reevaluate();
  return {};
}

std::optional<OwnIdentity::UnappliedRenewal> OwnIdentity::unapplied_renewal() const {
  const std::scoped_lock lock(mutex_);
  if (renewals_ <= applied_renewals_) return std::nullopt;
  return UnappliedRenewal{renewals_, authorities_renewal_ > applied_renewals_};
}

void OwnIdentity::note_applied(std::uint64_t renewal) {
  const std::scoped_lock lock(mutex_);
  applied_renewals_ = std::max(applied_renewals_, renewal);
}

Status OwnIdentity::set_permissions(const spi::Token& credential) {
  const std::string* document = spi::find_property(credential.properties, "dds.perm.cert");
  if (credential.class_id != spi::class_id::kPermissionsCredential || document == nullptr)
    return fail(Code::permissions_credential_wrong,
                {.expected = std::string(spi::class_id::kPermissionsCredential) +
                             " with property dds.perm.cert",
                 .found = credential.class_id.substr(0, 64)});
  std::string_view text = *document;
  if (text.ends_with('\0')) text.remove_suffix(1);
  if (text.size() > kMaxPermissionsOctets)
    return fail(Code::token_field_length,
                {.document = "permissions credential token",
                 .field = "dds.perm.cert",
                 .expected = "at most " + std::to_string(kMaxPermissionsOctets) + " octets",
                 .found = std::to_string(text.size()) + " octets"});
  auto octets = text.empty() ? Bytes(1) : to_bytes(as_bytes(text));
  const std::scoped_lock lock(mutex_);
  presented_ = std::make_shared<const PresentedDocuments>(
      PresentedDocuments{presented_->certificate, presented_->key, std::move(octets)});
  return {};
}

std::shared_ptr<const PresentedDocuments> OwnIdentity::presented() const {
  const std::scoped_lock lock(mutex_);
  return presented_;
}

// ---- a renewed certificate

// The subject must stay, because the GUID, the permissions and the counts of peers depend on it.
// The algorithm must stay, because the identity token in discovery names it. An older certificate
// would end sooner, or bring back a key that was replaced for a reason.
Status OwnIdentity::check_renewed(const IdentityWatch::FoundIdentity& found,
                                  const TrustStore& trust, WallTime now) const {
  const auto former = certificate();
  const auto& renewed = found.certificate;
  const auto differs = [](std::string_view field, std::string expected, std::string is,
                          std::string_view hint = "") {
    return fail(Code::identity_renewal_refused,
                {.document = std::string(property::kIdentityCertificate),
                 .field = std::string(field),
                 .expected = std::move(expected),
                 .found = std::move(is),
                 .hint = std::string(hint)});
  };
  const bool has_same_text = renewed.subject() == former.subject();
  if (renewed.subject_digest() != former.subject_digest() && has_same_text)
    return differs("subject", pki::subject_with_types(former), pki::subject_with_types(renewed),
                   "its CA writes the same subject in another string type, and the GUID depends on "
                   "it: start the participant again to use it");
  if (renewed.subject_digest() != former.subject_digest())
    return differs("subject", former.subject(), renewed.subject());
  if (renewed.key_algorithm() != former.key_algorithm())
    return differs("key algorithm", to_string(former.key_algorithm()),
                   to_string(renewed.key_algorithm()));
  if (renewed.not_before() < former.not_before())
    return differs("notBefore", to_string(former.not_before()) + " or later",
                   to_string(renewed.not_before()));
  if (renewed.not_after() < former.not_after())
    return differs("notAfter", to_string(former.not_after()) + " or later",
                   to_string(renewed.not_after()),
                   "it ends before the one in force: renew it with more --days, or start the "
                   "participant again to use it");
  DDSSEC_RETURN_IF_ERROR(with_property(found.key.check_fits(renewed), property::kPrivateKey));
  DDSSEC_RETURN_IF_ERROR(with_property(trust.verify(renewed, now), property::kIdentityCertificate));
  return {};
}

Result<bool> OwnIdentity::renew_identity(const Clock& clock) {
  const std::scoped_lock lock(renewal_mutex_);
  const auto former = presented();
  DDSSEC_ASSIGN_OR_RETURN(const auto found,
                          watch_.poll(clock.monotonic(), {former->certificate, former->key},
                                      [&](const IdentityWatch::FoundIdentity& one) {
                                        return check_renewed(one, *own_trust(),
                                                             clock.calendar_seconds());
                                      }));
  if (!found) return false;
  const std::scoped_lock presenting(mutex_);
  presented_ = std::make_shared<const PresentedDocuments>(
      PresentedDocuments{found->certificate, found->key, presented_->permissions});
  return true;
}

// ---- the OCSP response

Result<bool> OwnIdentity::renew_ocsp_response(const Clock& clock) {
  const std::scoped_lock lock(renewal_mutex_);
  const auto own = certificate();
  const auto trust = own_trust();
  auto taken = ocsp_response_.poll(clock.monotonic(), {own, *trust, clock.calendar_seconds()});
  const bool is_revoked = !taken && taken.error().code() == Code::ocsp_revoked;
  const std::scoped_lock presenting(mutex_);
  ocsp_in_force_ = ocsp_response_.in_force();
  ocsp_revoked_ = is_revoked ? std::optional(taken.error()) : std::nullopt;
  return taken;
}

std::shared_ptr<const OcspInForce> OwnIdentity::ocsp_response_for(
    const pki::Certificate& certificate, WallTime now) const {
  const std::scoped_lock lock(mutex_);
  const auto& one = ocsp_in_force_;
  return one && one->certificate == certificate && one->good.holds_at(now) ? one : nullptr;
}

std::optional<Error> OwnIdentity::ocsp_revoked() const {
  const std::scoped_lock lock(mutex_);
  return ocsp_revoked_;
}

// ---- other certificate authorities

// The caller holds mutex_. A new store does not remember which peers the former one trusted.
void OwnIdentity::trust(std::shared_ptr<const TrustStore> store) {
  own_trust_ = std::move(store);
  if (trusted_folder_) return;
  listed_->reevaluate();
  peer_trust_ = own_trust_;
  authorities_renewal_ = ++renewals_;
}

Result<OwnIdentity::AuthorityRenewal> OwnIdentity::renew_authorities(TrustStores& stores,
                                                                     const Clock& clock) {
  const std::scoped_lock lock(renewal_mutex_);
  AuthorityRenewal taken;
  const auto former = own_trust();
  const auto adopt = [&](const std::vector<pki::Certificate>& next) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(taken.identity,
                            adopt_authorities(next, stores, clock.calendar_seconds()));
    return {};
  };
  DDSSEC_ASSIGN_OR_RETURN(taken.authorities,
                          authorities_.poll(clock.monotonic(), former->anchors(), adopt));
  return taken;
}

Result<bool> OwnIdentity::renew_trusted_folder(TrustStores& stores, const Clock& clock) {
  const std::scoped_lock lock(renewal_mutex_);
  if (!trusted_folder_) return false;
  const auto adopt = [&](const std::vector<pki::Certificate>& next) -> Status {
    DDSSEC_RETURN_IF_ERROR(
        check_in_trusted_folder(own_trust()->anchors(), next, trusted_folder_->path()));
    DDSSEC_ASSIGN_OR_RETURN(auto store, stores.open(next, {}));
    const std::scoped_lock trusting(mutex_);
    peer_trust_ = std::move(store);
    authorities_renewal_ = ++renewals_;
    return {};
  };
  return trusted_folder_->poll(clock.monotonic(), peer_trust()->anchors(), adopt);
}

// Takes other authorities. Returns true if our certificate was renewed together with them.
Result<bool> OwnIdentity::adopt_authorities(const std::vector<pki::Certificate>& next,
                                            TrustStores& stores, WallTime now) {
  if (trusted_folder_)
    DDSSEC_RETURN_IF_ERROR(
        check_in_trusted_folder(next, peer_trust()->anchors(), trusted_folder_->path()));
  DDSSEC_ASSIGN_OR_RETURN(auto store, stores.open(next, revocation_lists_.in_force()));
  const auto former = presented();
  const auto own =
      with_property(store->verify(former->certificate, now), property::kIdentityCertificate);
  if (own) {
    const std::scoped_lock lock(mutex_);
    trust(std::move(store));
    return false;
  }
  // A CA that is replaced without overlap has issued our certificate again.
  const auto found = watch_.read({former->certificate, former->key});
  if (!found || found->certificate == former->certificate) return std::unexpected(own.error());
  DDSSEC_RETURN_IF_ERROR(adopt_with_identity(next, *found, stores, now));
  return true;
}

Status OwnIdentity::adopt_with_identity(const std::vector<pki::Certificate>& next,
                                        const IdentityWatch::FoundIdentity& identity,
                                        TrustStores& stores, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto lists, revocation_lists_.read(next, now));
  DDSSEC_RETURN_IF_ERROR(check_renewal(lists.in_force(), revocation_lists_.in_force(), next, now));
  DDSSEC_ASSIGN_OR_RETURN(auto store, stores.open(next, lists.in_force()));
  DDSSEC_RETURN_IF_ERROR(check_renewed(identity, *store, now));
  revocation_lists_ = std::move(lists);
  const std::scoped_lock lock(mutex_);
  trust(std::move(store));
  presented_ = std::make_shared<const PresentedDocuments>(
      PresentedDocuments{identity.certificate, identity.key, presented_->permissions});
  return {};
}

// ---- descriptions for a person

// The caller holds renewal_mutex_.
DocumentState OwnIdentity::state_of_authorities() const {
  DocumentState state{.kind = DocumentKind::identity_ca,
                      .file = authorities_.name(),
                      .parts = pki::parts_of(peer_trust()->anchors()),
                      .refused = authorities_.refused(),
                      .state = authorities_.state()};
  if (!trusted_folder_) return state;
  state.file += ", " + trusted_folder_->path();
  if (!state.refused) state.refused = trusted_folder_->refused();
  state.state = std::max(state.state, trusted_folder_->state());
  return state;
}

std::vector<DocumentState> OwnIdentity::documents() const {
  const std::scoped_lock lock(renewal_mutex_);
  const auto path = watch_.path();
  std::vector<DocumentState> out = {
      {.kind = DocumentKind::identity_certificate,
       .file = path.empty() ? std::string(property::kIdentityCertificate) : path,
       .parts = {pki::part_of(certificate())},
       .refused = watch_.refused(),
       .state = watch_.state()},
      state_of_authorities()};
  if (const auto state = ocsp_response_.state(certificate())) out.push_back(*state);
  if (const auto state = listed_->state()) out.push_back(*state);
  if (revocation_lists_.path().empty()) return out;
  out.push_back({.kind = DocumentKind::revocation_list,
                 .file = revocation_lists_.path(),
                 .parts = {},
                 .refused = revocation_lists_.refused(),
                 .state = revocation_lists_.state()});
  for (const auto& list : revocation_lists_.in_force())
    out.back().parts.push_back({.subject = list.issuer(),
                                .number = list.number() ? to_string(*list.number()) : "",
                                .until = list.next_update()});
  return out;
}

void OwnIdentity::force_poll() {
  const std::scoped_lock lock(renewal_mutex_);
  watch_.force_poll();
  authorities_.force_poll();
  if (trusted_folder_) trusted_folder_->force_poll();
  revocation_lists_.force_poll();
  ocsp_response_.force_poll();
  listed_->force_poll();
}

// ---- the documents that are presented

Sha256Digest OwnIdentity::hash_of(const std::shared_ptr<const PresentedDocuments>& presented,
                                  const Credentials& own) const {
  Bytes variable = to_bytes(own.participant_data);
  const auto name = own.key_agreement_algorithm;
  variable.insert(variable.end(), name.begin(), name.end());
  const std::scoped_lock lock(mutex_);
  // Another certificate may have been presented since.
  if (presented != presented_) return own.hash();
  if (known_hash_ && known_hash_->presented == presented && known_hash_->variable == variable)
    return known_hash_->digest;
  known_hash_ = KnownHash{std::move(variable), presented, own.hash()};
  return known_hash_->digest;
}

}  // namespace ddssec::authentication
