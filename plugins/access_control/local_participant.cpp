#include "plugins/access_control/local_participant.hpp"

#include "governance/live_change.hpp"
#include "plugins/access_control/protection.hpp"

namespace ddssec::access_control {
namespace {

bool are_alike(const governance::TopicRule* former, const governance::TopicRule* next) {
  if (former == nullptr || next == nullptr) return former == next;
  return governance::protect_alike(*former, *next);
}

// A document with the revision in force has the content in force.
bool is_same_revision(const governance::CompiledGovernance& former,
                      const governance::CompiledGovernance& next) {
  return next.revision() != 0 && next.revision() == former.revision();
}

Error old_revision_error(const governance::CompiledGovernance& former,
                         const governance::CompiledGovernance& next) {
  const auto revision = next.revision();
  return Error(Code::governance_renewal_refused,
               {.field = "revision",
                .expected = "more than " + std::to_string(former.revision()) + ", the one in force",
                .found = revision == 0 ? "none" : std::to_string(revision),
                .hint = "sign the document again with ddssec governance sign, which writes the "
                        "next revision, if it is not an old one that was put back"});
}

// `what`: whose protection the document changes.
Status check_has_revision(const governance::CompiledGovernance& next, int line, std::string what) {
  if (next.revision() != 0) return {};
  return fail(
      Code::governance_renewal_refused,
      {.line = line,
       .field = "revision",
       .expected = "a revision, since the document changes " + std::move(what),
       .found = "none",
       .hint = "sign the document with ddssec governance sign, which writes one, or restart "
               "the participant"});
}

Status check_has_revision(const governance::CompiledGovernance& next,
                          const governance::TopicRule& raised) {
  return check_has_revision(next, raised.line,
                            "the protection of \"" + raised.topic_expression + "\"");
}

// Returns the error for a topic that cannot change while this participant uses it.
Error topic_in_use_error(const std::string& topic, const governance::TopicRule* rule,
                         const Error& why) {
  auto details = why.details();
  if (details.field.empty()) {
    details.field = "topic_rule";
    details.found = rule == nullptr ? "no rule" : "a rule";
  }
  details.line = rule == nullptr ? 0 : rule->line;
  if (!details.note.empty()) details.note += "; ";
  details.note += "this participant uses the topic \"" + topic + "\": restart it";
  return Error(Code::governance_renewal_refused, std::move(details));
}

// Returns the error for a change that no running participant of the domain takes.
Error not_live_error(const Error& why) {
  auto details = why.details();
  if (details.hint.empty())
    details.hint =
        "if it is not an old document that was put back, restart all participants of the domain "
        "with it; ddssec governance diff OLD NEW says which of them match until all have it";
  return Error(why.code(), std::move(details));
}

// `former` and `next` differ in more than a host can take that does not change what exists.
Error not_at_once_error(const governance::CompiledGovernance& former,
                        const governance::CompiledGovernance& next) {
  const auto change = governance::live_change(former.domain_rule(), next.domain_rule());
  if (change && !change->domain.empty()) {
    const auto& kind = change->domain.front();
    return Error(Code::governance_renewal_refused,
                 {.line = kind.line,
                  .field = std::string(kind.element),
                  .expected = kind.former,
                  .found = kind.next,
                  .note = "this host cannot change it while it runs",
                  .hint = "restart the participant when the embedded participants of the domain "
                          "have the document"});
  }
  return Error(Code::governance_renewal_refused,
               {.field = "topic_rule",
                .expected = "the protection that the topics in use have",
                .found = "more protection, which this host cannot give endpoints that exist",
                .hint = "restart the participant"});
}

}  // namespace

std::shared_ptr<const JudgingDocuments> LocalParticipant::judging_documents() const {
  const std::lock_guard lock(mutex_);
  return judging_documents_;
}

std::shared_ptr<const ListedPermissions> LocalParticipant::listed() const {
  const std::lock_guard lock(mutex_);
  return listed_;
}

void LocalParticipant::set_listed(std::shared_ptr<const ListedPermissions> listed) {
  const std::lock_guard lock(mutex_);
  listed_ = std::move(listed);
}

Result<std::shared_ptr<const JudgingDocuments>> LocalParticipant::use_topic(
    std::string_view topic) {
  const std::lock_guard lock(mutex_);
  const bool is_builtin =
      builtin_attributes(judging_documents_->governance->domain_rule(), topic).has_value();
  if (is_builtin || topics_in_use_.contains(topic)) return judging_documents_;
  DDSSEC_RETURN_IF_ERROR(check_new_topic(topic));
  has_more_topics_ = has_more_topics_ || topics_in_use_.size() >= kMaxTopicsInUse;
  if (!has_more_topics_) topics_in_use_.emplace(topic);
  return judging_documents_;
}

// If there were too many topics, it is not known whether others are in use that were not recorded.
void LocalParticipant::forget_topic(std::string_view topic) {
  const std::lock_guard lock(mutex_);
  const auto known = topics_in_use_.find(topic);
  if (known != topics_in_use_.end() && !has_more_topics_) topics_in_use_.erase(known);
}

// Checks a topic that came into use after the waiting document was checked against the topics in
// use. The caller holds mutex_.
Status LocalParticipant::check_new_topic(std::string_view topic) const {
  if (!pending_) return {};
  const auto under_way_error = [&](ErrorDetails details) {
    details.note += (details.note.empty() ? "" : "; ") + std::string("the topic \"") +
                    std::string(topic) + "\" was not in use when revision " +
                    std::to_string(pending_->governance->revision()) + " of the document was taken";
    return std::unexpected(Error(Code::governance_change_under_way, std::move(details)));
  };
  if (topics_in_use_.size() >= kMaxTopicsInUse)
    return under_way_error({.field = "topics in use",
                            .expected = "fewer than " + std::to_string(kMaxTopicsInUse),
                            .found = "more"});
  const auto* const before = judging_documents_->governance->topic_rule(topic);
  const auto* const after = pending_->governance->topic_rule(topic);
  if (are_alike(before, after)) return {};
  if (before == nullptr || after == nullptr)
    return under_way_error(
        {.line = after == nullptr ? 0 : after->line,
         .field = "topic_rule",
         .expected = before == nullptr ? "none" : "one, as in the document in force",
         .found = after == nullptr ? "none" : "one"});
  const auto fits =
      governance::check_topic_change(*before, pending_->governance->domain_rule(), *after);
  if (fits) return {};
  return under_way_error(fits.error().details());
}

Result<LocalParticipant::Change> LocalParticipant::check_governance(
    const governance::CompiledGovernance& next) const {
  const std::lock_guard lock(mutex_);
  return check(next);
}

Status LocalParticipant::set_judging_documents(JudgingDocuments documents) {
  auto next = std::make_shared<const JudgingDocuments>(std::move(documents));
  const std::lock_guard lock(mutex_);
  if (judging_documents_ && next->governance != judging_documents_->governance) {
    DDSSEC_ASSIGN_OR_RETURN(const auto change, check(*next->governance));
    if (change == Change::phased)
      return std::unexpected(not_at_once_error(*judging_documents_->governance, *next->governance));
  }
  judging_documents_ = std::move(next);
  return {};
}

std::shared_ptr<const LocalParticipant::PendingGovernance> LocalParticipant::pending() const {
  const std::lock_guard lock(mutex_);
  return pending_;
}

void LocalParticipant::set_pending(PendingGovernance pending) {
  auto next = std::make_shared<const PendingGovernance>(std::move(pending));
  const std::lock_guard lock(mutex_);
  pending_ = std::move(next);
}

void LocalParticipant::drop_pending() {
  const std::lock_guard lock(mutex_);
  pending_ = nullptr;
}

std::shared_ptr<const governance::CompiledGovernance> LocalParticipant::governance_of(
    const Sha256Digest& digest) const {
  const std::lock_guard lock(mutex_);
  if (pending_ && pending_->digest == digest) return pending_->governance;
  return former_.digest == digest ? former_.governance : nullptr;
}

bool LocalParticipant::apply_pending(const Sha256Digest& digest) {
  const std::lock_guard lock(mutex_);
  if (!pending_ || pending_->digest != digest) return false;
  auto documents = std::make_shared<JudgingDocuments>(*judging_documents_);
  former_ = {documents->governance, documents->governance_digest};
  documents->governance = pending_->governance;
  documents->governance_digest = pending_->digest;
  judging_documents_ = std::move(documents);
  pending_ = nullptr;
  return true;
}

// The caller holds mutex_.
Result<LocalParticipant::Change> LocalParticipant::check(
    const governance::CompiledGovernance& next) const {
  const auto& former = *judging_documents_->governance;
  if (next.revision() < former.revision()) return std::unexpected(old_revision_error(former, next));
  const auto live = governance::live_change(former.domain_rule(), next.domain_rule());
  if (!live) return std::unexpected(not_live_error(live.error()));
  const auto& change = *live;
  if (!change.raised.empty()) DDSSEC_RETURN_IF_ERROR(check_has_revision(next, *change.raised[0]));
  for (const auto& kind : change.domain)
    DDSSEC_RETURN_IF_ERROR(check_has_revision(next, kind.line, std::string(kind.element)));
  if (is_same_revision(former, next) && !change.is_empty())
    return std::unexpected(old_revision_error(former, next));
  auto out = change.domain.empty() ? Change::at_once : Change::phased;
  for (const auto& topic : topics_in_use_) {
    const auto* const before = former.topic_rule(topic);
    const auto* const after = next.topic_rule(topic);
    if (are_alike(before, after)) continue;
    const auto fits = before == nullptr || after == nullptr
                          ? Status(std::unexpected(Error(Code::governance_renewal_refused)))
                          : governance::check_topic_change(*before, next.domain_rule(), *after);
    if (!fits) return std::unexpected(topic_in_use_error(topic, after, fits.error()));
    DDSSEC_RETURN_IF_ERROR(check_has_revision(next, *after));
    out = Change::phased;
  }
  // A topic that had no rule is not in use.
  if (!has_more_topics_ || (change.are_last && change.raised.empty())) return out;
  return fail(Code::governance_renewal_refused,
              {.field = "topic_rule",
               .expected = "further rules after the others: this participant uses more than " +
                           std::to_string(kMaxTopicsInUse) + " topics; restart it",
               .found = "a rule before another one, or one with other values"});
}

}  // namespace ddssec::access_control
