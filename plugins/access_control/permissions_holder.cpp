#include "plugins/access_control/permissions_holder.hpp"

#include <algorithm>

#include "governance/grant.hpp"
#include "plugins/access_control/listed_permissions.hpp"

namespace ddssec::access_control {
namespace {

Error replaced(const std::string& document, const Grant& former, const Grant& listed) {
  return Error(Code::peer_permissions_replaced,
               {.document = document,
                .field = "not_before",
                .expected = to_string(former->grant().validity.not_before),
                .found = to_string(listed->grant().validity.not_before),
                .hint = "put the later permissions into the peer's folder: as long as it presents "
                        "the former ones, only what both allow is allowed"});
}

}  // namespace

void PermissionsHolder::set_own(std::string text, std::unique_ptr<OwnDocuments> documents) {
  text_ = std::move(text);
  digest_ = digest_of_file(text_);
  own_documents_ = std::move(documents);
}

void PermissionsHolder::note_seen(std::shared_ptr<const PermissionsHolder> own,
                                  const spi::SessionFacts& facts) {
  auto seen = own->presented(facts.presented_permissions);
  const std::lock_guard lock(mutex_);
  seen_ = std::move(seen);
  reads_lists_ = facts.peer_reads_lists;
  own_ = std::move(own);
}

std::shared_ptr<PermissionsDocument> PermissionsHolder::presented(
    const std::optional<Sha256Digest>& digest) const {
  const std::lock_guard lock(mutex_);
  if (former_.empty() || (digest && *digest == digest_)) return document_;
  if (digest) {
    const auto found = std::ranges::find(former_, *digest, &Former::digest);
    if (found != former_.end()) return found->document;
  }
  return former_.front().document;
}

bool PermissionsHolder::is_over(WallTime now) const {
  return now >= grant_->grant().validity.not_after || now > document_->signer_not_after();
}

std::shared_ptr<PermissionsDocument> PermissionsHolder::document() const {
  const std::lock_guard lock(mutex_);
  return document_;
}

Result<Grant> PermissionsHolder::grant_in(PermissionsDocument& document, WallTime now) const {
  return document.grant_for(subject_.name, subject_.shown, participant_->domain,
                            participant_->domain_tag, now);
}

/// Of a peer. Our own documents are judged before other CAs come into force.
Status PermissionsHolder::check_signer() {
  const auto ca = participant_->basis()->ca;
  if (!remote_ || ca == accepted_by_) return {};
  for (const auto& document : {document_, presented_ ? presented_->document : document_})
    if (!ca->holds(document->signer()))
      return fail(Code::permissions_ca_withdrawn,
                  {.document = document_name_,
                   .expected = "signed by " + pki::describe(ca->verifier().permissions_cas()),
                   .found = "signed by " + pki::describe({document->signer()})});
  accepted_by_ = ca;
  return {};
}

bool PermissionsHolder::give_the_same_here(const Grant& a, const Grant& b) const {
  return give_the_same(a->grant(), b->grant(), participant_->domain, participant_->domain_tag);
}

Result<Grant> PermissionsHolder::grant(WallTime now) {
  const std::lock_guard lock(mutex_);
  return valid_grant(now);
}

Result<std::vector<Grant>> PermissionsHolder::grants(WallTime now) {
  const std::lock_guard lock(mutex_);
  DDSSEC_ASSIGN_OR_RETURN(auto grant, valid_grant(now));
  std::vector<Grant> out{std::move(grant)};
  if (presented_) out.push_back(presented_->grant);
  return out;
}

/// The lock is held.
Status PermissionsHolder::check_presented(WallTime now) const {
  if (!presented_) return {};
  auto status = governance::check_validity(presented_->grant->grant(), now);
  if (status) status = presented_->document->check_signer(now);
  if (!status) return std::unexpected(status.error().in(document_name_));
  return {};
}

/// The lock is held.
Result<Grant> PermissionsHolder::valid_grant(WallTime now) {
  if (!document_) return fail(Code::peer_has_no_permissions);
  if (replaced_) return std::unexpected(*replaced_);
  DDSSEC_RETURN_IF_ERROR(check_signer());
  DDSSEC_RETURN_IF_ERROR(check_presented(now));
  if (grant_ && !is_over(now)) return grant_;
  auto found = grant_in(*document_, now);
  if (!found) return std::unexpected(found.error().in(document_name_));
  // Hosts do not judge again what they have matched.
  if (remote_ && grant_ && !give_the_same_here(grant_, *found))
    if (auto ended = governance::check_validity(grant_->grant(), now); !ended)
      return std::unexpected(ended.error().in(document_name_));
  grant_ = *found;
  return grant_;
}

std::optional<WallTime> PermissionsHolder::ends() const {
  const std::lock_guard lock(mutex_);
  if (!grant_ || reported_) return std::nullopt;
  // A certificate is valid up to and including its last second.
  const auto end_of = [](const Grant& grant, const PermissionsDocument& document) {
    return std::min(grant->grant().validity.not_after,
                    document.signer_not_after() + std::chrono::seconds(1));
  };
  const auto end = end_of(grant_, *document_);
  return presented_ ? std::min(end, end_of(presented_->grant, *presented_->document)) : end;
}

std::optional<Error> PermissionsHolder::newly_ended(WallTime now) {
  if (auto over = outlived(now)) return over;
  if (!has_document()) return std::nullopt;
  auto valid = grant(now);
  const std::lock_guard lock(mutex_);
  if (valid || reported_) return std::nullopt;
  return std::move(valid).error();
}

std::optional<Error> PermissionsHolder::ends_soon(WallTime now) {
  const auto end = ends();
  if (!end) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!warning_.is_due(grant_->grant().validity.not_before, *end, now)) return std::nullopt;
  if (grant_in(*document_, *end)) return std::nullopt;
  return Error(
      Code::permissions_end_soon,
      {.document = document_name_, .field = "not_after", .found = spi::in_time(*end, now)});
}

std::string PermissionsHolder::text() const {
  const std::lock_guard lock(mutex_);
  return text_;
}

std::uint64_t PermissionsHolder::renewals() const {
  const std::lock_guard lock(mutex_);
  return renewals_;
}

std::vector<Error> PermissionsHolder::renew(DocumentCache& documents, const Clock& clock) {
  const std::lock_guard lock(renewal_mutex_);
  if (!own_documents_) return {};
  return own_documents_->renew(*this, *participant_, documents, clock);
}

/// The end also if it was reported.
DocumentPart PermissionsHolder::permissions_part() const {
  const std::lock_guard lock(mutex_);
  DocumentPart out{.subject = subject_.shown, .sha256 = to_hex(digest_)};
  if (grant_)
    out.until = std::min(grant_->grant().validity.not_after, document_->signer_not_after());
  return out;
}

std::vector<DocumentState> PermissionsHolder::documents() const {
  const std::lock_guard lock(renewal_mutex_);
  if (!own_documents_) return {};
  return own_documents_->states(*participant_, permissions_part());
}

void PermissionsHolder::look_now() {
  const std::lock_guard lock(renewal_mutex_);
  if (own_documents_) own_documents_->look_now();
}

void PermissionsHolder::look_at_list_now() {
  const std::lock_guard lock(renewal_mutex_);
  if (own_documents_) own_documents_->look_at_list_now();
}

std::vector<Error> PermissionsHolder::read_list(DocumentCache& documents, const Clock& clock) {
  const std::lock_guard lock(renewal_mutex_);
  if (!own_documents_) return {};
  return own_documents_->read_list(*this, *participant_, documents, clock);
}

/// The lock is held.
Status PermissionsHolder::check_follows(const Grant& renewed) const {
  // The host has cut the participant off, and keeps to that.
  if (reported_)
    return fail(Code::permissions_renewal_refused, {.note = "the participant has ended"});
  const auto begin = renewed->grant().validity.not_before;
  if (grant_ && begin < grant_->grant().validity.not_before)
    return fail(Code::permissions_renewal_refused,
                {.field = "not_before",
                 .expected = to_string(grant_->grant().validity.not_before) + " or later",
                 .found = to_string(begin)});
  return {};
}

Result<bool> PermissionsHolder::take_shown(std::shared_ptr<PermissionsDocument> document,
                                           WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto renewed, grant_in(*document, now));
  const std::lock_guard lock(mutex_);
  if (document == document_) return false;
  DDSSEC_RETURN_IF_ERROR(check_follows(renewed));
  DDSSEC_RETURN_IF_ERROR(check_not_former({document, renewed}, now));
  document_ = std::move(document);
  grant_ = std::move(renewed);
  presented_.reset();
  accepted_by_.reset();
  return true;
}

Status PermissionsHolder::take(std::shared_ptr<PermissionsDocument> document, BytesView file,
                               WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto renewed, grant_in(*document, now));
  std::string text(as_text(file));
  const std::lock_guard lock(mutex_);
  DDSSEC_RETURN_IF_ERROR(check_follows(renewed));
  constexpr std::size_t kMostFormer = 8;
  if (former_.size() == kMostFormer) former_.erase(former_.begin() + 1);
  former_.push_back({digest_, std::move(document_)});
  document_ = std::move(document);
  grant_ = std::move(renewed);
  digest_ = digest_of_file(text);
  text_ = std::move(text);
  ++renewals_;
  return {};
}

// ---- permissions of the renewal list

std::optional<ListedPermissions::Found> PermissionsHolder::latest_listed(WallTime now) const {
  const auto listed = participant_->listed();
  if (!listed) return std::nullopt;
  return listed->latest({subject_.name, subject_.shown, participant_->domain,
                         participant_->domain_tag, *participant_->basis()->ca, now});
}

/// The lock is held. What the list took away does not come back by showing former permissions.
Status PermissionsHolder::check_not_former(const ListedPermissions::Found& shown,
                                           WallTime now) const {
  const auto listed = latest_listed(now);
  if (!listed || !supersedes(*listed, shown) || give_the_same_here(listed->grant, shown.grant))
    return {};
  return fail(Code::permissions_renewal_refused,
              {.field = "not_before",
               .expected = "those of the renewal list, which give other rights and begin on " +
                           to_string(listed->grant->grant().validity.not_before) +
                           ", or permissions that begin or were signed later",
               .found = to_string(shown.grant->grant().validity.not_before)});
}

std::optional<Error> PermissionsHolder::follow_list(WallTime now, bool is_new) {
  const std::lock_guard lock(mutex_);
  if (!remote_ || !grant_ || reported_ || replaced_) return std::nullopt;
  const ListedPermissions::Found present{document_, grant_};
  auto found = latest_listed(now);
  const bool is_other =
      found && supersedes(*found, present) && !give_the_same_here(found->grant, grant_);
  if (!is_other) other_rights_since_.reset();
  if (!is_other && (!found || !is_later(*found, present) || !is_valid(*found, now) ||
                    !give_the_same_here(found->grant, grant_)))
    return std::nullopt;
  if (is_other && (!is_new || !is_valid(*found, now))) {
    if (!other_rights_since_) other_rights_since_ = now;
    if (now - *other_rights_since_ >= participant_->listed_rights_wait)
      replaced_ = replaced(document_name_, grant_, found->grant);
    return std::nullopt;
  }
  if (is_other) presented_ = present;
  document_ = std::move(found->document);
  grant_ = std::move(found->grant);
  accepted_by_.reset();
  return Error(
      Code::peer_permissions_listed,
      {.document = document_name_,
       .field = "not_after",
       .found = to_string(grant_->grant().validity.not_after),
       .note = is_other ? "they give other rights than those that the peer presented: only "
                          "what both allow is allowed, until the first of them ends"
                        : ""});
}

bool PermissionsHolder::is_listed() const {
  const auto listed = participant_->listed();
  const std::lock_guard lock(mutex_);
  return listed && listed->holds(digest_);
}

std::optional<Error> PermissionsHolder::outlived(WallTime now) {
  std::shared_ptr<const PermissionsHolder> own;
  std::shared_ptr<PermissionsDocument> seen;
  bool reads_lists = false;
  {
    const std::lock_guard lock(mutex_);
    if (reported_) return std::nullopt;
    own = own_;
    seen = seen_;
    reads_lists = reads_lists_;
  }
  if (!own || !seen || own->document() == seen) return std::nullopt;
  const auto still = own->grant_in(*seen, now);
  if (still) return std::nullopt;
  // If the peer has no such list, it ends the session, and we follow.
  if (reads_lists && own->is_listed()) {
    auto present = own->document();
    const std::lock_guard lock(mutex_);
    seen_ = std::move(present);
    return std::nullopt;
  }
  auto details = still.error().details();
  details.document = own->document_name_;
  details.hint.clear();
  return Error(Code::session_outlived_documents, std::move(details));
}

void PermissionsHolder::mark_reported() {
  const std::lock_guard lock(mutex_);
  reported_ = true;
}

}  // namespace ddssec::access_control
