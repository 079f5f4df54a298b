#include "plugins/authentication/listed_renewals.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "base/renewal_refusals.hpp"
#include "pki/document_parts.hpp"
#include "pki/key_digests.hpp"
#include "pki/withdrawn_authorities.hpp"
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
  if (!trust.is_on_any_list(certificate)) return true;
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

// Verifies the next certificates that wait.
void ListedRenewals::verify_some(JudgedList& list, const TrustStore& trust, WallTime now) {
  const auto count = std::min(list.waiting.size(), kMaxVerifiedInAPoll);
  const auto end = list.waiting.begin() + static_cast<std::ptrdiff_t>(count);
  for (auto one = list.waiting.begin(); one != end; ++one) {
    const auto verdict = trust.verify(*one, now);
    if (verdict || is_about_time(verdict.error().code())) {
      list.usable.push_back(*one);
      continue;
    }
    ++list.foreign;
    if (!list.first_fault) list.first_fault = verdict.error().with_default_document(one->subject());
  }
  list.waiting.erase(list.waiting.begin(), end);
  if (list.waiting.empty() && !list.usable.empty()) list.former.clear();
}

Status ListedRenewals::check_counts(const JudgedList& list, const TrustStore& trust) {
  const auto& first = list.first_fault;
  if (!list.waiting.empty() || !list.usable.empty() || !first) return {};
  return fail(Code::renewal_list_refused,
              {.field = first->details().document,
               .expected = "certificates of " + pki::describe(trust.anchors()),
               .found = "none that counts",
               .note = std::string(info(first->code()).summary)});
}

Status ListedRenewals::adopt(const pki::RenewalList& list, const TrustStore& trust, WallTime now) {
  std::set<Sha256Digest> known;
  if (verdicts_hold_)
    for (const auto& one : list_.usable) known.insert(one.fingerprint());
  JudgedList next{.former = list_.former.empty() ? list_.usable : list_.former,
                  .permissions = list.permissions.size()};
  for (const auto& one : list.certificates)
    (known.contains(one.fingerprint()) ? next.usable : next.waiting).push_back(one);
  verify_some(next, trust, now);
  DDSSEC_RETURN_IF_ERROR(check_counts(next, trust));
  if (next.waiting.empty()) next.former.clear();
  list_ = std::move(next);
  verdicts_hold_ = true;
  refused_when_verified_.reset();
  return {};
}

Error ListedRenewals::taken_event() const {
  const auto& [usable, waiting, former, permissions, foreign, fault] = list_;
  return Error(Code::renewal_list_taken,
               {.document = watch_.path(),
                .found = std::to_string(usable.size()) + " certificates, " +
                         std::to_string(permissions) + " permissions",
                .note = foreign == 0 ? ""
                                     : std::to_string(foreign) +
                                           " more certificates do not count: they are revoked, "
                                           "or of no CA that is trusted here"});
}

// Returns the event about a list of which all entries are verified.
Result<std::optional<Error>> ListedRenewals::note_verified(const TrustStore& trust) {
  if (is_reported_ || !list_.waiting.empty()) return std::nullopt;
  is_reported_ = true;
  const auto status = check_counts(list_, trust);
  if (status) return taken_event();
  list_.usable = std::exchange(list_.former, {});
  refused_when_verified_ =
      renewal_refused_error(Code::renewal_list_refused, status.error(), watch_.path(),
                            list_.usable.empty() ? "" : "the list read before stays in force");
  return std::unexpected(*refused_when_verified_);
}

Result<std::optional<Error>> ListedRenewals::poll(const Clock& clock, const TrustStore& trust) {
  const std::scoped_lock lock(mutex_);
  bool was_judged = false;
  const auto taken = watch_.poll(clock.monotonic(), [&](const pki::RenewalList& list) {
    was_judged = true;
    return adopt(list, trust, clock.calendar_seconds());
  });
  if (!was_judged) verify_some(list_, trust, clock.calendar_seconds());
  DDSSEC_RETURN_IF_ERROR(taken);
  if (*taken) is_reported_ = false;
  return note_verified(trust);
}

void ListedRenewals::force_poll() {
  const std::scoped_lock lock(mutex_);
  watch_.force_poll();
}

void ListedRenewals::reevaluate() {
  const std::scoped_lock lock(mutex_);
  verdicts_hold_ = false;
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

ListedRenewals::FoundCertificate ListedRenewals::after(const Session& session,
                                                       const TrustStore& trust,
                                                       WallTime now) const {
  const std::scoped_lock lock(mutex_);
  FoundCertificate out;
  const auto judge = [&](const pki::Certificate& listed) {
    if (listed.subject_digest() != session.proven.subject_digest() || listed == session.latest)
      return;
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
  };
  for (const auto* const all : {&list_.usable, &list_.waiting, &list_.former})
    std::ranges::for_each(*all, judge);
  return out;
}

std::optional<DocumentState> ListedRenewals::state() const {
  const std::scoped_lock lock(mutex_);
  const auto refused = refused_when_verified_ ? refused_when_verified_ : watch_.refused();
  if (list_.usable.empty() && list_.permissions == 0 && !refused) return std::nullopt;
  return DocumentState{.kind = DocumentKind::renewal_list,
                       .file = watch_.path(),
                       .parts = pki::parts_of(list_.usable),
                       .refused = refused,
                       .state = refused_when_verified_ ? FileState::refused : watch_.state()};
}

}  // namespace ddssec::authentication
