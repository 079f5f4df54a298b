#include "plugins/authentication/listed_renewals.hpp"

#include <algorithm>

#include "pki/document_parts.hpp"
#include "pki/key_digests.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/renewal_list_places.hpp"

namespace ddssec::authentication {
namespace {

// True for an entry that is skipped without a report: it has ended, or it counts later.
bool is_about_time(Code code) {
  return code == Code::certificate_expired || code == Code::certificate_not_yet_valid;
}

// True if the certificate is known not to be revoked. False also if its status cannot be
// determined.
bool is_not_revoked(const pki::Certificate& certificate, const TrustStore& trust, WallTime now) {
  if (!trust.may_be_revoked(certificate)) return true;
  const auto verdict = trust.verify(certificate, now);
  return verdict || verdict.error().code() == Code::certificate_expired;
}

bool have_same_key(const pki::Certificate& a, const pki::Certificate& b) {
  return a.key_algorithm() == b.key_algorithm() && pki::key_digest(a) == pki::key_digest(b);
}

}  // namespace

Result<std::shared_ptr<ListedRenewals>> ListedRenewals::of(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto interval, spi::files_poll_interval(properties));
  DDSSEC_ASSIGN_OR_RETURN(const auto places, spi::renewal_list_places(properties));
  return std::make_shared<ListedRenewals>(places, interval);
}

Status ListedRenewals::adopt(const pki::RenewalList& list, const TrustStore& trust, WallTime now) {
  std::vector<pki::Certificate> usable;
  std::optional<Error> first;
  std::size_t foreign = 0;
  for (const auto& certificate : list.certificates) {
    const auto verdict = trust.verify(certificate, now);
    if (verdict || is_about_time(verdict.error().code())) {
      usable.push_back(certificate);
      continue;
    }
    ++foreign;
    if (!first) first = verdict.error().with_document(certificate.subject());
  }
  if (usable.empty() && first)
    return fail(Code::renewal_list_refused,
                {.field = first->details().document,
                 .expected = "certificates of " + pki::describe(trust.anchors()),
                 .found = "none that counts",
                 .note = std::string(info(first->code()).summary)});
  certificates_ = std::move(usable);
  permissions_ = list.permissions.size();
  foreign_ = foreign;
  return {};
}

Result<std::optional<Error>> ListedRenewals::poll(const Clock& clock, const TrustStore& trust) {
  const std::scoped_lock lock(mutex_);
  DDSSEC_ASSIGN_OR_RETURN(const bool taken,
                          watch_.poll(clock.monotonic(), [&](const pki::RenewalList& list) {
                            return adopt(list, trust, clock.now());
                          }));
  if (!taken) return std::nullopt;
  return Error(Code::renewal_list_taken,
               {.document = watch_.path(),
                .found = std::to_string(certificates_.size()) + " certificates, " +
                         std::to_string(permissions_) + " permissions",
                .note = foreign_ == 0 ? ""
                                      : std::to_string(foreign_) +
                                            " more certificates do not count: they are revoked, "
                                            "or of no CA that is trusted here"});
}

void ListedRenewals::force_poll() {
  const std::scoped_lock lock(mutex_);
  watch_.force_poll();
}

void ListedRenewals::reevaluate() {
  const std::scoped_lock lock(mutex_);
  watch_.reevaluate();
}

// Returns the reason why the certificate may not replace the latest one; empty if it may.
std::string ListedRenewals::refusal_of(const pki::Certificate& listed,
                                       const Session& session) const {
  // The session proves only that the peer has the key of its handshake.
  if (!have_same_key(listed, session.proven)) return "it is of another key";
  if (listed.not_before() < session.latest.not_before())
    return "it begins before the one that has ended";
  return {};
}

ListedRenewals::Found ListedRenewals::after(const Session& session, const TrustStore& trust,
                                            WallTime now) const {
  const std::scoped_lock lock(mutex_);
  Found out;
  for (const auto& listed : certificates_) {
    if (listed.subject_digest() != session.proven.subject_digest() || listed == session.latest)
      continue;
    auto why_not = refusal_of(listed, session);
    if (why_not.empty() && !is_not_revoked(session.proven, trust, now))
      why_not = "the certificate of the handshake was revoked";
    if (why_not.empty()) {
      auto chain = trust.verify(listed, now);
      if (chain && (!out.chain || out.chain->not_after() < chain->not_after()))
        out.chain = *std::move(chain);
      if (!chain) why_not = std::string(info(chain.error().code()).summary);
    }
    if (!why_not.empty())
      out.why_not = "the renewal list " + watch_.path() +
                    " has the certificate with serial number " + listed.serial() +
                    ", which does not count: " + why_not;
  }
  return out;
}

bool ListedRenewals::holds(const pki::Certificate& certificate) const {
  const std::scoped_lock lock(mutex_);
  return std::ranges::find(certificates_, certificate) != certificates_.end();
}

std::optional<DocumentState> ListedRenewals::state() const {
  const std::scoped_lock lock(mutex_);
  const auto refused = watch_.refused();
  if (certificates_.empty() && permissions_ == 0 && !refused) return std::nullopt;
  DocumentState out{.kind = DocumentKind::renewal_list,
                    .file = watch_.path(),
                    .parts = pki::parts_of(certificates_),
                    .refused = refused};
  // The end of an entry needs no attention, so it is not shown.
  for (auto& part : out.parts) part.until.reset();
  return out;
}

}  // namespace ddssec::authentication
