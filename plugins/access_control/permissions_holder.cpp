#include "plugins/access_control/permissions_holder.hpp"

#include <algorithm>

#include "base/time_left.hpp"
#include "governance/grant.hpp"
#include "plugins/access_control/listed_permissions.hpp"

namespace ddssec::access_control {
namespace {

// Returns the digest of a signed file, computed as authentication does (session_facts.hpp).
Sha256Digest digest_of_file(std::string_view text) {
  constexpr std::string_view kNone("", 1);
  if (text.ends_with('\0')) text.remove_suffix(1);
  return sha256(as_bytes(text.empty() ? kNone : text));
}

bool is_over(const SharedGrant& grant, const PermissionsDocument& document, WallTime now) {
  return now >= grant->grant().validity.not_after || now > document.signer_not_after();
}

// A grant that was valid does not end because the clock goes back.
Status check_not_over(const GrantOfDocument& one, WallTime now) {
  if (!is_over(one.grant, *one.document, now)) return {};
  DDSSEC_RETURN_IF_ERROR(governance::check_validity(one.grant->grant(), now));
  return one.document->check_signer(now);
}

// The same second does not count as earlier.
Status check_signed_later(const PermissionsDocument& former, const PermissionsDocument& next) {
  if (is_signed_later(next, former)) return {};
  const auto since = former.signing_time(), time = next.signing_time();
  return fail(Code::permissions_renewal_refused,
              {.field = "signing time",
               .expected = to_string(*since) + " or later",
               .found = time ? to_string(*time) : "none",
               .note = "the document was signed before the one in force",
               .hint = "put the later document back; to go back to earlier rights, sign them "
                       "again: ddssec permissions sign FILE.xml --ca CA -o FOLDER/permissions.p7s "
                       "--replace"});
}

// Some tools end a file with a NUL. It is not signed, and hosts whose texts end at a NUL cannot
// send it.
std::string without_trailing_nul(std::string text) {
  if (text.ends_with('\0')) text.pop_back();
  return text;
}

}  // namespace

void PermissionsHolder::set_own(std::string text, std::unique_ptr<OwnDocuments> documents) {
  digest_ = digest_of_file(text);
  text_ = without_trailing_nul(std::move(text));
  own_documents_ = std::move(documents);
}

void PermissionsHolder::note_seen(std::shared_ptr<const PermissionsHolder> own,
                                  const spi::SessionFacts& facts) {
  auto seen = own->presented(facts.presented_permissions);
  const std::lock_guard lock(mutex_);
  seen_ = std::move(seen);
  seen_extension_.reset();
  reads_lists_ = facts.peer_reads_lists;
  must_end_ = false;
  own_ = std::move(own);
}

PermissionsHolder::OutdatedGrant PermissionsHolder::outdated_grant_seen() const {
  std::shared_ptr<const PermissionsHolder> own;
  GrantOfDocument seen;
  bool must_end = false;
  {
    const std::lock_guard lock(mutex_);
    if (is_reported_ || !reads_lists_ || !own_ || !seen_) return {};
    own = own_;
    seen = *seen_;
    must_end = must_end_;
  }
  if (own->document() == seen.document) return {};
  return {std::move(seen.grant), must_end};
}

void PermissionsHolder::note_must_end() {
  const std::lock_guard lock(mutex_);
  must_end_ = true;
}

GrantOfDocument PermissionsHolder::presented(const std::optional<Sha256Digest>& digest) const {
  const std::lock_guard lock(mutex_);
  if (former_.empty() || (digest && *digest == digest_)) return {document_, grant_};
  if (digest) {
    const auto found = std::ranges::find(former_, *digest, &FormerDocument::digest);
    if (found != former_.end()) return found->permissions;
  }
  return former_.front().permissions;
}

std::shared_ptr<PermissionsDocument> PermissionsHolder::document() const {
  const std::lock_guard lock(mutex_);
  return document_;
}

Result<SharedGrant> PermissionsHolder::grant_in(PermissionsDocument& document, WallTime now) const {
  return document.grant_for(subject_.name, subject_.shown, participant_->domain,
                            participant_->domain_tag, now);
}

// Checks a peer's document. Our own documents are judged before other CAs come into force.
Status PermissionsHolder::check_signer(const PermissionsDocument& document) const {
  const auto ca = participant_->judging_documents()->ca;
  if (ca->holds(document.signer())) return {};
  return fail(Code::permissions_ca_withdrawn,
              {.document = document_name_,
               .expected = "signed by " + pki::describe(ca->verifier().permissions_cas()),
               .found = "signed by " + pki::describe({document.signer()})});
}

// The caller holds the lock.
Result<SharedGrant> PermissionsHolder::presented_grant(WallTime now) {
  if (const auto ca = participant_->judging_documents()->ca; remote_ && ca != accepted_by_) {
    DDSSEC_RETURN_IF_ERROR(check_signer(*document_));
    accepted_by_ = ca;
  }
  if (grant_ && !is_over(grant_, *document_, now)) return grant_;
  DDSSEC_ASSIGN_OR_RETURN(auto found,
                          with_default_document(grant_in(*document_, now), document_name_));
  // Hosts do not judge their existing matches again.
  if (remote_ && grant_ &&
      !give_same_rights(grant_->grant(), found->grant(), participant_->domain,
                        participant_->domain_tag))
    DDSSEC_RETURN_IF_ERROR(
        with_default_document(governance::check_validity(grant_->grant(), now), document_name_));
  grant_ = std::move(found);
  return grant_;
}

// The caller holds the lock.
Status PermissionsHolder::check_extension(WallTime now) const {
  DDSSEC_RETURN_IF_ERROR(check_signer(*extension_->document));
  return check_not_over(*extension_, now);
}

// The caller holds the lock. The extension may give more, so it decides only how long the grant
// counts.
Result<SharedGrant> PermissionsHolder::valid_grant(WallTime now) {
  if (!document_) return fail(Code::peer_has_no_permissions);
  if (!extension_) return presented_grant(now);
  const auto status = check_extension(now);
  if (status) return grant_;
  if (auto presented = presented_grant(now)) return presented;
  return std::unexpected(status.error().with_default_document(document_name_));
}

Result<SharedGrant> PermissionsHolder::grant(WallTime now) {
  const std::lock_guard lock(mutex_);
  return valid_grant(now);
}

// Returns the last end of the documents whose CAs are in the file; empty if there is none. The
// caller holds the lock.
std::optional<WallTime> PermissionsHolder::last_end() const {
  const auto ca = participant_->judging_documents()->ca;
  std::optional<WallTime> out;
  const auto add = [&](const GrantOfDocument& one) {
    if (remote_ && !ca->holds(one.document->signer())) return;
    out = std::max(out.value_or(WallTime::min()), end_of(one));
  };
  add({document_, grant_});
  if (extension_) add(*extension_);
  return out;
}

std::optional<WallTime> PermissionsHolder::ends() const {
  const std::lock_guard lock(mutex_);
  if (!grant_ || is_reported_) return std::nullopt;
  return last_end().value_or(end_of({document_, grant_}));
}

std::optional<Error> PermissionsHolder::newly_ended(WallTime now) {
  if (auto over = outlived(now)) return over;
  if (!has_document()) return std::nullopt;
  auto valid = grant(now);
  const std::lock_guard lock(mutex_);
  if (valid || is_reported_) return std::nullopt;
  return std::move(valid).error();
}

std::optional<Error> PermissionsHolder::ends_soon(WallTime now) {
  const auto end = ends();
  if (!end) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!warning_.is_due(grant_->grant().validity.not_before, *end, now)) return std::nullopt;
  if (grant_in(*document_, *end)) return std::nullopt;
  return Error(Code::permissions_end_soon,
               {.document = document_name_, .field = "not_after", .found = in_time(*end, now)});
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

void PermissionsHolder::force_poll() {
  const std::lock_guard lock(renewal_mutex_);
  if (own_documents_) own_documents_->force_poll();
}

void PermissionsHolder::force_poll_of_list() {
  const std::lock_guard lock(renewal_mutex_);
  if (own_documents_) own_documents_->force_poll_of_list();
}

// The caller holds the lock.
Status PermissionsHolder::check_follows(const PermissionsDocument& document,
                                        const SharedGrant& renewed) const {
  // The host has cut the participant off and does not change that.
  if (is_reported_)
    return fail(Code::permissions_renewal_refused, {.note = "the participant has ended"});
  const auto begin = renewed->grant().validity.not_before;
  if (grant_ && begin < grant_->grant().validity.not_before)
    return fail(Code::permissions_renewal_refused,
                {.field = "not_before",
                 .expected = to_string(grant_->grant().validity.not_before) + " or later",
                 .found = to_string(begin)});
  return document_ ? check_signed_later(*document_, document) : Status();
}

Result<PresentedRights> PermissionsHolder::adopt_presented(
    std::shared_ptr<PermissionsDocument> document, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto renewed, grant_in(*document, now));
  const std::lock_guard lock(mutex_);
  if (document == document_) return PresentedRights::same;
  DDSSEC_RETURN_IF_ERROR(check_follows(*document, renewed));
  const bool has_less =
      grant_ != nullptr && !gives_at_least(renewed->grant(), grant_->grant(), participant_->domain,
                                           participant_->domain_tag);
  document_ = std::move(document);
  grant_ = std::move(renewed);
  extension_.reset();
  accepted_by_.reset();
  return has_less ? PresentedRights::fewer : PresentedRights::no_fewer;
}

Status PermissionsHolder::adopt(std::shared_ptr<PermissionsDocument> document, BytesView file,
                                WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto renewed, grant_in(*document, now));
  std::string text(as_text(file));
  const std::lock_guard lock(mutex_);
  DDSSEC_RETURN_IF_ERROR(check_follows(*document, renewed));
  constexpr std::size_t kMaxFormer = 8;
  if (former_.size() == kMaxFormer) former_.erase(former_.begin() + 1);
  former_.push_back({digest_, {std::move(document_), std::move(grant_)}});
  document_ = std::move(document);
  grant_ = std::move(renewed);
  digest_ = digest_of_file(text);
  text_ = without_trailing_nul(std::move(text));
  ++renewals_;
  return {};
}

// ---- permissions of the renewal list

std::optional<GrantOfDocument> PermissionsHolder::extension_of(const GrantOfDocument& presented,
                                                               ExtendingRights by,
                                                               WallTime now) const {
  const auto listed = participant_->listed();
  if (!listed || !presented.grant) return std::nullopt;
  return listed->extension_of(
      {subject_.name, subject_.shown, participant_->domain, participant_->domain_tag,
       *presented.document, presented.grant->grant(), by},
      *participant_->judging_documents()->ca, now);
}

// True if the peer announced an endpoint that its permissions do not allow, and `others` do. The
// caller holds the lock.
bool PermissionsHolder::are_wanted(const SharedGrant& others) const {
  return std::ranges::any_of(denied_.all(), [&](const AllowedEndpoints::One& one) {
    std::vector<governance::DataTag> tags;
    for (const auto& tag : one->data_tags) tags.push_back({tag.name, tag.value});
    const auto partitions = one->partitions.views();
    const governance::Request asked{one->topic, partitions, tags};
    return others->judge(one->action, asked).allowed && !grant_->judge(one->action, asked).allowed;
  });
}

void PermissionsHolder::note_denied(governance::Action action, const spi::EndpointRequest& asked) {
  denied_.note(action, asked);
  const std::lock_guard lock(mutex_);
  if (extension_ && are_wanted(extension_->grant)) extension_.reset();
}

std::optional<Error> PermissionsHolder::follow_list(WallTime now) {
  const std::lock_guard lock(mutex_);
  if (!remote_ || !grant_ || is_reported_) return std::nullopt;
  const auto ends_later = [&](const std::optional<GrantOfDocument>& one) {
    const auto end = last_end();
    return one && (!end || end_of(*one) > *end);
  };
  auto found = extension_of({document_, grant_}, ExtendingRights::at_least_the_same, now);
  if (!ends_later(found)) return std::nullopt;
  if (are_wanted(found->grant))
    found = extension_of({document_, grant_}, ExtendingRights::the_same, now);
  if (!ends_later(found)) return std::nullopt;
  extension_ = std::move(found);
  return Error(
      Code::peer_permissions_listed,
      {.document = document_name_, .field = "not_after", .found = to_string(end_of(*extension_))});
}

std::optional<Error> PermissionsHolder::outlived(WallTime now) {
  std::shared_ptr<const PermissionsHolder> own;
  std::optional<GrantOfDocument> seen, extension;
  bool reads_lists = false;
  {
    const std::lock_guard lock(mutex_);
    if (is_reported_) return std::nullopt;
    own = own_;
    seen = seen_;
    extension = seen_extension_;
    reads_lists = reads_lists_;
  }
  if (!own || !seen || own->document() == seen->document) return std::nullopt;
  const auto status = check_not_over(*seen, now);
  // Another grant of the document may have replaced it.
  if (status || own->grant_in(*seen->document, now)) return std::nullopt;
  // The peer continues by its list. If it has no such list, it ends the session, and we follow.
  if (extension && check_not_over(*extension, now)) return std::nullopt;
  if (auto extended = reads_lists
                          ? own->extension_of(*seen, ExtendingRights::at_least_the_same, now)
                          : std::nullopt) {
    const std::lock_guard lock(mutex_);
    seen_extension_ = std::move(extended);
    return std::nullopt;
  }
  auto details = status.error().details();
  details.document = own->document_name_;
  details.hint.clear();
  return Error(Code::session_outlived_documents, std::move(details));
}

void PermissionsHolder::mark_reported() {
  const std::lock_guard lock(mutex_);
  is_reported_ = true;
}

}  // namespace ddssec::access_control
