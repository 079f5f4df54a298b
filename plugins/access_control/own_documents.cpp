#include "plugins/access_control/own_documents.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "governance/live_change.hpp"
#include "pki/certificate_source.hpp"
#include "pki/document_parts.hpp"
#include "plugins/access_control/allowed_algorithms.hpp"
#include "plugins/access_control/loading.hpp"

namespace ddssec::access_control {
namespace {

DocumentWatch::WatchedDocument what(const std::string& uri, const std::string& name,
                                    std::size_t max_octets, Code refused, std::string_view stays) {
  return {.uri = uri, .name = name, .max_octets = max_octets, .refused = refused, .stays = stays};
}

// Adds the remedy for the document's fault, because a restart with the document would fail.
DocumentWatch::WatchedDocument signed_document(DocumentWatch::WatchedDocument what) {
  what.gives_remedy_of_reason = true;
  return what;
}

// Returns nothing if `octets` fit, and otherwise the file as it is now if that fits. If neither
// fits, the error is about the file as it is now, or about `octets` if the file has no other
// content.
template <class Fits>
Result<std::optional<Bytes>> one_that_fits(BytesView octets, const DocumentWatch& file,
                                           Fits&& fits) {
  const Status in_force = fits(octets);
  if (in_force) return std::nullopt;
  auto present = file.read();
  if (!present || std::ranges::equal(*present, octets)) return std::unexpected(in_force.error());
  DDSSEC_RETURN_IF_ERROR(fits(*present));
  return std::move(*present);
}

// Returns the event about the changes in a document in force; empty if only its form has changed.
std::optional<Error> changed(const governance::DomainRule& former,
                             const governance::DomainRule& next) {
  const auto change = governance::live_change(former, next);
  if (!change || (change->rules.empty() && change->raised.empty())) return std::nullopt;
  const auto& rules = change->rules.empty() ? change->raised : change->rules;
  return Error(Code::governance_renewed,
               {.line = rules.front()->line,
                .field = "topic_rule",
                .found = std::to_string(rules.size()) +
                         (change->rules.empty() ? " with more protection" : " more") +
                         ", the first for \"" + rules.front()->topic_expression + "\""});
}

// The event contains a part of the digest, so that the rate limit does not take two documents with
// the same end for one event.
Error renewed_event(const std::string& file, const DocumentPart& permissions) {
  constexpr std::size_t kShownDigits = 16;
  return Error(Code::permissions_renewed,
               {.document = file,
                .field = "not_after",
                .found = fmt::format("{}, sha256 {}...",
                                     permissions.until ? to_string(*permissions.until) : "none",
                                     permissions.sha256.substr(0, kShownDigits))});
}

// A document ends with its last grant, or with the certificate that signed it.
DocumentPart listed_part(const PermissionsDocument& document, const Sha256Digest& file) {
  const auto& grants = document.permissions().grants;
  auto until = WallTime::min();
  for (const auto& grant : grants) until = std::max(until, grant.validity.not_after);
  DocumentPart out{.until = std::min(until, document.signer_not_after()), .sha256 = to_hex(file)};
  if (!grants.empty()) out.subject = grants.front().subject_name;
  if (grants.size() > 1) out.subject += fmt::format(" and {} more", grants.size() - 1);
  return out;
}

}  // namespace

struct OwnDocuments::Renewal {
  PermissionsHolder& holder;
  LocalParticipant& participant;
  DocumentCache& documents;
  const Clock& clock;
};

OwnDocuments::OwnDocuments(const DocumentPlaces& places, const AccessControlOptions& options,
                           std::chrono::seconds interval)
    : options_(options),
      keeps_permissions_(!options.presents_renewed_permissions()),
      authorities_(what(places.permissions_ca, places.permissions_ca_name, 0,
                        Code::permissions_ca_renewal_refused, "the CAs read before stay in force"),
                   interval),
      governance_(signed_document(what(places.governance, places.governance_name,
                                       pki::kMaxDocumentOctets, Code::governance_renewal_refused,
                                       "the document read before stays in force")),
                  interval),
      permissions_(
          signed_document(what(places.permissions, places.permissions_name,
                               pki::kMaxSentPermissionsOctets, Code::permissions_renewal_refused,
                               "the permissions read before stay in force")),
          keeps_permissions_ ? std::chrono::seconds(0) : interval),
      identity_authorities_(what(places.identity_ca, places.identity_ca, pki::kMaxBundleOctets,
                                 Code::identity_ca_renewal_refused, ""),
                            interval),
      renewal_list_(places.renewal_list, interval, Code::renewal_list_permissions_refused) {}

void OwnDocuments::note_read(Bytes governance, BytesView permissions) {
  governance_.note_read(governance);
  permissions_.note_read(permissions);
  governance_in_force_ = std::move(governance);
}

void OwnDocuments::force_poll() {
  authorities_.force_poll();
  governance_.force_poll();
  permissions_.force_poll();
  identity_authorities_.force_poll();
  renewal_list_.force_poll();
}

std::vector<DocumentState> OwnDocuments::states(const LocalParticipant& participant,
                                                DocumentPart permissions) const {
  const auto documents = participant.judging_documents();
  const auto part_of = [](const governance::CompiledGovernance& rules, BytesView file) {
    return DocumentPart{.subject = rules.revision() == 0
                                       ? "no revision"
                                       : fmt::format("revision {}", rules.revision()),
                        .sha256 = to_hex(sha256(file))};
  };
  std::optional<DocumentPart> waiting;
  if (const auto pending = participant.pending(); pending && governance_waiting_)
    waiting = part_of(*pending->governance, *governance_waiting_);
  std::vector<DocumentState> out = {
      {.kind = DocumentKind::permissions_ca,
       .file = authorities_.name(),
       .parts = pki::parts_of(documents->ca->verifier().permissions_cas()),
       .refused = authorities_.refused(),
       .state = authorities_.state()},
      {.kind = DocumentKind::permissions,
       .file = permissions_.name(),
       .parts = {std::move(permissions)},
       .refused = permissions_.refused(),
       .state = permissions_.state()},
      {.kind = DocumentKind::governance,
       .file = governance_.name(),
       .parts = {part_of(*documents->governance, governance_in_force_)},
       .refused = governance_.refused(),
       .waiting = std::move(waiting),
       .state = governance_.state()}};
  if (auto listed = state_of_list()) out.push_back(*std::move(listed));
  return out;
}

// Authentication shows a list that cannot be read, which is not refused here.
std::optional<DocumentState> OwnDocuments::state_of_list() const {
  auto refused = list_refused_when_verified_;
  if (!refused && is_list_refused_) refused = renewal_list_.refused();
  if (!had_listed_ && !refused) return std::nullopt;
  const bool is_candidate = renewal_list_.state() == FileState::candidate;
  const auto state = refused        ? FileState::refused
                     : is_candidate ? FileState::candidate
                                    : FileState::current;
  return DocumentState{.kind = DocumentKind::listed_permissions,
                       .file = renewal_list_.path(),
                       .parts = listed_parts_,
                       .refused = std::move(refused),
                       .state = state};
}

std::vector<Error> OwnDocuments::renew(PermissionsHolder& holder, LocalParticipant& participant,
                                       DocumentCache& documents, const Clock& clock) {
  const Renewal now{holder, participant, documents, clock};
  std::vector<Error> events;
  const auto renewals = holder.renewals();
  if (const auto applied = note_applied(participant)) events.push_back(*applied);
  // The CAs come first, because a new CA may have signed a renewed document.
  renew_identity_authorities(now);
  renew_authorities(now, events);
  renew_governance(now, events);
  renew_permissions(now, events);
  renew_list(now, events);
  keep_one_of_folder(events);
  if (holder.renewals() == renewals) return events;
  events.push_back(renewed_event(permissions_.name(), holder.permissions_part()));
  return events;
}

void OwnDocuments::keep_one_of_folder(std::vector<Error>& events) const {
  std::set<std::string> told;
  const auto slash = identity_authorities_.name().rfind('/');
  if (!keeps_permissions_ && slash != std::string::npos)
    told.insert(identity_authorities_.name().substr(0, std::max<std::size_t>(slash, 1)));
  std::erase_if(events, [&](const Error& event) {
    return event.code() == Code::folder_unreadable && !told.insert(event.details().document).second;
  });
}

// ---- certificate authorities

void OwnDocuments::renew_authorities(const Renewal& now, std::vector<Error>& events) {
  const auto documents = now.participant.judging_documents();
  const auto taken = authorities_.poll(
      now.clock.monotonic(), documents->ca->verifier().permissions_cas(),
      [&](const std::vector<pki::Certificate>& next) { return adopt_authorities(now, next); });
  if (!taken) events.push_back(taken.error());
  if (!taken || !*taken) return;
  renewal_list_.reevaluate();
  const auto ca = now.participant.judging_documents()->ca;
  events.emplace_back(Code::permissions_ca_renewed,
                      ErrorDetails{.document = authorities_.name(),
                                   .found = pki::describe(ca->verifier().permissions_cas())});
  if (const auto what = changed(documents->governance->domain_rule(),
                                now.participant.judging_documents()->governance->domain_rule()))
    events.emplace_back(Code::governance_renewed,
                        what->with_default_document(governance_.name()).details());
  if (const auto dropped = drop_withdrawn(now)) events.push_back(*dropped);
}

// A document that waits must be signed by one of the CAs that are in force now.
std::optional<Error> OwnDocuments::drop_withdrawn(const Renewal& now) {
  if (!governance_waiting_ || !now.participant.pending()) return std::nullopt;
  const auto judged =
      judge_governance(now, *now.participant.judging_documents(), *governance_waiting_);
  if (judged) return std::nullopt;
  now.participant.drop_pending();
  governance_waiting_.reset();
  auto details = judged.error().details();
  details.note =
      "it waited to come into force, and its CA has left the permissions CA file; the "
      "document read before stays in force";
  return Error(Code::governance_renewal_refused, std::move(details))
      .with_default_document(governance_.name());
}

Status OwnDocuments::adopt_authorities(const Renewal& now,
                                       const std::vector<pki::Certificate>& next) {
  auto documents = *now.participant.judging_documents();
  DDSSEC_ASSIGN_OR_RETURN(documents.ca, PermissionsCa::of(next));
  if (const auto* const allowed = documents.allowed_algorithms())
    for (const auto& ca : next) DDSSEC_RETURN_IF_ERROR(check_authority(*allowed, ca));
  const auto time = now.clock.calendar_seconds();
  const auto fits_governance = [&](BytesView file) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(auto judged, judge_governance(now, documents, file));
    documents = std::move(judged.documents);
    return {};
  };
  DDSSEC_ASSIGN_OR_RETURN(auto&& governance,
                          one_that_fits(governance_in_force_, governance_, fits_governance));
  const auto fits_permissions = [&](BytesView file) -> Status {
    DDSSEC_RETURN_IF_ERROR(now.documents.permissions(*documents.ca, file, time));
    return {};
  };
  const auto text = now.holder.text();
  if (keeps_permissions_) {
    DDSSEC_RETURN_IF_ERROR(fits_permissions(as_bytes(text)));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto permissions,
                          one_that_fits(as_bytes(text), permissions_, fits_permissions));
  if (permissions) {
    DDSSEC_ASSIGN_OR_RETURN(auto document,
                            now.documents.permissions(*documents.ca, *permissions, time));
    DDSSEC_RETURN_IF_ERROR(now.holder.adopt(std::move(document), *permissions, time));
    permissions_.note_read(*permissions);
  }
  DDSSEC_RETURN_IF_ERROR(now.participant.set_judging_documents(std::move(documents)));
  if (!governance) return {};
  governance_.note_read(*governance);
  governance_in_force_ = *std::move(governance);
  return {};
}

// CAs that were there before stay. They are only used to find the algorithm of a CA that
// authentication trusts.
void OwnDocuments::renew_identity_authorities(const Renewal& now) {
  auto documents = *now.participant.judging_documents();
  if (documents.allowed_algorithms() == nullptr) return;
  const auto ignored =
      identity_authorities_.poll(now.clock.monotonic(), [&](BytesView file) -> Status {
        DDSSEC_ASSIGN_OR_RETURN(auto all, pki::Certificate::bundle_from_pem(file));
        for (const auto& ca : documents.identity_authorities)
          if (all.size() < pki::kMaxCertificatesInBundle && std::ranges::find(all, ca) == all.end())
            all.push_back(ca);
        documents.identity_authorities = std::move(all);
        return now.participant.set_judging_documents(std::move(documents));
      });
  static_cast<void>(ignored);
}

// ---- governance

Result<OwnDocuments::JudgedGovernance> OwnDocuments::judge_governance(
    const Renewal& now, const JudgingDocuments& documents, BytesView file) const {
  JudgedGovernance out{documents};
  DDSSEC_ASSIGN_OR_RETURN(auto verified,
                          compile_governance({*documents.ca, now.participant, options_}, file,
                                             now.clock.calendar_seconds()));
  DDSSEC_ASSIGN_OR_RETURN(const auto change, now.participant.check_governance(*verified.rules));
  out.documents.governance = std::move(verified.rules);
  out.documents.governance_digest = verified.digest;
  out.is_phased = change == LocalParticipant::Change::phased;
  return out;
}

Status OwnDocuments::adopt_governance(const Renewal& now, const JudgingDocuments& former,
                                      BytesView file) {
  DDSSEC_ASSIGN_OR_RETURN(auto judged, judge_governance(now, former, file));
  if (judged.is_phased && options_.host_changes_protection) {
    now.participant.set_pending({judged.documents.governance, judged.documents.governance_digest});
    governance_waiting_ = to_bytes(file);
    return {};
  }
  DDSSEC_RETURN_IF_ERROR(now.participant.set_judging_documents(std::move(judged.documents)));
  governance_in_force_ = to_bytes(file);
  return {};
}

std::optional<Error> OwnDocuments::note_applied(const LocalParticipant& participant) {
  if (!governance_waiting_ || participant.pending()) return std::nullopt;
  governance_in_force_ = *std::exchange(governance_waiting_, std::nullopt);
  return Error(Code::governance_renewed,
               {.document = governance_.name(),
                .field = "revision",
                .found = std::to_string(participant.judging_documents()->governance->revision())});
}

void OwnDocuments::renew_governance(const Renewal& now, std::vector<Error>& events) {
  if (governance_waiting_) return;
  const auto former = now.participant.judging_documents();
  const auto taken = governance_.poll(
      now.clock.monotonic(), [&](BytesView file) { return adopt_governance(now, *former, file); });
  if (!taken) events.push_back(taken.error());
  if (!taken || !*taken) return;
  if (const auto pending = now.participant.pending()) {
    events.emplace_back(Code::governance_changing,
                        ErrorDetails{.document = governance_.name(),
                                     .field = "revision",
                                     .found = std::to_string(pending->governance->revision())});
    return;
  }
  if (const auto what = changed(former->governance->domain_rule(),
                                now.participant.judging_documents()->governance->domain_rule()))
    events.emplace_back(Code::governance_renewed,
                        what->with_default_document(governance_.name()).details());
}

// ---- permissions

void OwnDocuments::renew_permissions(const Renewal& now, std::vector<Error>& events) {
  const auto looked = permissions_.poll(now.clock.monotonic(), [&](BytesView file) -> Status {
    const auto time = now.clock.calendar_seconds();
    const auto documents = now.participant.judging_documents();
    DDSSEC_ASSIGN_OR_RETURN(auto document, now.documents.permissions(*documents->ca, file, time));
    return now.holder.adopt(std::move(document), file, time);
  });
  if (!looked) events.push_back(looked.error());
}

// ---- the renewal list

// Returns the document if it was verified before.
std::optional<OwnDocuments::ListedFile> OwnDocuments::known(const Renewal& now,
                                                            BytesView file) const {
  const auto ca = now.participant.judging_documents()->ca;
  const auto digest = sha256(file);
  for (const auto* const all : {&listed_.verified, &listed_.former})
    if (const auto one = std::ranges::find(*all, digest, &ListedFile::file);
        one != all->end() && ca->holds(one->document->signer()))
      return *one;
  return std::nullopt;
}

// An entry that was signed by no CA of the file does not count.
void OwnDocuments::verify_some(const Renewal& now, ListedFiles& list) const {
  const auto ca = now.participant.judging_documents()->ca;
  const auto count =
      verifies_all_ ? list.waiting.size() : std::min(list.waiting.size(), kMaxVerifiedInAPoll);
  const auto end = list.waiting.begin() + static_cast<std::ptrdiff_t>(count);
  for (auto file = list.waiting.begin(); file != end; ++file) {
    auto document = now.documents.permissions(*ca, *file, now.clock.calendar_seconds());
    if (document)
      list.verified.push_back({sha256(*file), *std::move(document)});
    else if (!list.fault)
      list.fault = std::move(document).error();
  }
  list.waiting.erase(list.waiting.begin(), end);
  if (list.waiting.empty() && list.counts()) list.former.clear();
}

void OwnDocuments::use_list(const Renewal& now) {
  ListedPermissions::Documents documents;
  std::vector<DocumentPart> parts;
  for (const auto* const all : {&listed_.verified, &listed_.former})
    for (const auto& one : *all) {
      documents.push_back(one.document);
      parts.push_back(listed_part(*one.document, one.file));
    }
  listed_parts_ = std::move(parts);
  had_listed_ = had_listed_ || !listed_parts_.empty();
  now.participant.set_listed(std::make_shared<const ListedPermissions>(std::move(documents)));
}

Status OwnDocuments::adopt_list(const Renewal& now, const pki::RenewalList& list) {
  ListedFiles next{.former = listed_.former.empty() ? listed_.verified : listed_.former};
  for (const auto& file : list.permissions) {
    if (auto one = known(now, file))
      next.verified.push_back(*std::move(one));
    else
      next.waiting.push_back(file);
  }
  verify_some(now, next);
  if (!next.counts()) return std::unexpected(*next.fault);
  list_refused_when_verified_.reset();
  listed_ = std::move(next);
  use_list(now);
  return {};
}

// Verifies the next files of a long list. Returns the event if none of them counts: the former list
// then stays in force.
std::optional<Error> OwnDocuments::continue_list(const Renewal& now) {
  if (listed_.waiting.empty()) return std::nullopt;
  verify_some(now, listed_);
  std::optional<Error> out;
  if (!listed_.counts()) {
    out = renewal_refused_error(
        Code::renewal_list_permissions_refused, *listed_.fault, renewal_list_.path(),
        listed_.former.empty() ? "" : "the list read before stays in force");
    list_refused_when_verified_ = out;
    listed_ = {.verified = std::move(listed_.former)};
  }
  use_list(now);
  return out;
}

void OwnDocuments::renew_list(const Renewal& now, std::vector<Error>& events) {
  bool was_read = false;
  const auto taken = renewal_list_.poll(now.clock.monotonic(), [&](const pki::RenewalList& list) {
    was_read = true;
    auto status = adopt_list(now, list);
    is_list_refused_ = !status;
    return status;
  });
  if (!taken && was_read) events.push_back(taken.error());
  if (!was_read)
    if (const auto refused = continue_list(now)) events.push_back(*refused);
  verifies_all_ = false;
}

}  // namespace ddssec::access_control
