#include "plugins/access_control/access_control.hpp"

#include <algorithm>
#include <array>
#include <mutex>

#include <fmt/format.h>

#include "plugins/access_control/access_decisions.hpp"
#include "plugins/access_control/handle_table.hpp"
#include "plugins/access_control/listed_permission_peers.hpp"
#include "plugins/access_control/loading.hpp"
#include "plugins/access_control/protection.hpp"
#include "plugins/access_control/refusals.hpp"
#include "plugins/access_control/unknown_rights.hpp"
#include "plugins/spi/property_names.hpp"
#include "plugins/spi/session_facts.hpp"

namespace ddssec::access_control {
namespace {

using governance::Action;
using spi::EndpointRequest;
using spi::PermissionsHandle;

class AccessControlPlugin final : public spi::AccessControl {
 public:
  AccessControlPlugin(const PluginServices& services, AccessControlOptions options)
      : services_(services),
        options_(std::move(options)),
        decisions_(services_.clock, options_.accept_relays),
        documents_(options_.one_partition_suffices ? governance::PartitionMatch::one
                                                   : governance::PartitionMatch::all,
                   kMaxCachedDocuments, kMaxCachedOctets),
        handles_(options_.max_handles) {}

  Result<PermissionsHandle> validate_local_permissions(spi::IdentityHandle identity,
                                                       DomainId domain_id,
                                                       const spi::PropertyList& properties,
                                                       std::string_view domain_tag) override {
    auto holder = load_local(context(), identity, domain_id, properties, domain_tag);
    if (!holder) return report_local_error(holder.error());
    DDSSEC_ASSIGN_OR_RETURN(const auto handle, add(*holder));
    note_documents(handle);
    return handle;
  }

  Result<PermissionsHandle> validate_remote_permissions(spi::IdentityHandle local_identity,
                                                        spi::IdentityHandle remote_identity,
                                                        const spi::Token& permissions_token,
                                                        const spi::Token& credential) override;

  Result<bool> renew_remote_permissions(PermissionsHandle remote,
                                        const spi::Token& permissions_token,
                                        const spi::Token& credential) override;
  Status note_presented(PermissionsHandle remote, const spi::SessionFacts& facts) override;

  Status check_create_participant(PermissionsHandle local, DomainId domain_id) override {
    return check(local, domain_id, [&](auto& h) { return decisions_.check_participant(h); });
  }
  Status check_create_datawriter(PermissionsHandle local, DomainId domain_id,
                                 const EndpointRequest& request) override {
    return check(local, domain_id,
                 [&](auto& h) { return decisions_.check_announced(h, Action::publish, request); });
  }
  Status check_create_datareader(PermissionsHandle local, DomainId domain_id,
                                 const EndpointRequest& request) override {
    return check(local, domain_id, [&](auto& h) {
      return decisions_.check_announced(h, Action::subscribe, request);
    });
  }
  Status check_create_topic(PermissionsHandle local, DomainId domain_id,
                            std::string_view topic_name) override {
    return check(local, domain_id, [&](auto& h) { return decisions_.check_topic(h, topic_name); });
  }

  // A peer is judged like a local participant: by the local governance and its own permissions.
  Status check_remote_participant(PermissionsHandle remote, DomainId domain_id) override {
    return check_create_participant(remote, domain_id);
  }
  Status check_remote_datawriter(PermissionsHandle remote, DomainId domain_id,
                                 const EndpointRequest& request) override {
    return check_create_datawriter(remote, domain_id, request);
  }
  Result<RemoteDatareader> check_remote_datareader(PermissionsHandle remote, DomainId domain_id,
                                                   const EndpointRequest& request) override;
  Status check_remote_match(PermissionsHandle remote, const Match& match) override;
  Status check_remote_topic(PermissionsHandle remote, DomainId domain_id,
                            std::string_view topic_name) override {
    return check_create_topic(remote, domain_id, topic_name);
  }

  Result<spi::Token> permissions_token(PermissionsHandle local) override {
    DDSSEC_RETURN_IF_ERROR(find_or_refuse(local));
    // Fast DDS accepts only its own spelling of dds.perm_ca.sn and dds.perm_ca.algo, so none are
    // sent.
    return spi::Token{.class_id = std::string(spi::class_id::kPermissions)};
  }
  Result<spi::Token> permissions_credential_token(PermissionsHandle local) override {
    DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(local));
    return spi::Token{.class_id = std::string(spi::class_id::kPermissionsCredential),
                      .properties = {{"dds.perm.cert", holder->text()}}};
  }

  Result<spi::ParticipantSecurityAttributes> participant_sec_attributes(
      PermissionsHandle local) override {
    DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(local));
    return participant_attributes(
        holder->participant()->judging_documents()->governance->domain_rule());
  }
  Result<spi::TopicSecurityAttributes> topic_sec_attributes(PermissionsHandle local,
                                                            std::string_view topic_name) override {
    DDSSEC_ASSIGN_OR_RETURN(auto endpoint_attributes, attributes(local, topic_name));
    return std::move(endpoint_attributes).topic;
  }
  Result<spi::EndpointSecurityAttributes> datawriter_sec_attributes(
      PermissionsHandle local, const EndpointRequest& request) override {
    return attributes(local, request.topic_name);
  }
  Result<spi::EndpointSecurityAttributes> datareader_sec_attributes(
      PermissionsHandle local, const EndpointRequest& request) override {
    return attributes(local, request.topic_name);
  }

  Result<spi::EndpointSecurityAttributes> unused_topic_attributes(
      PermissionsHandle local, std::string_view topic_name) override {
    DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(local));
    const auto documents = holder->participant()->judging_documents();
    if (auto found = topic_attributes(*documents->governance, topic_name)) return *found;
    return std::unexpected(topic_not_covered_error(*holder->participant(), topic_name));
  }
  void forget_topic(PermissionsHandle local, std::string_view topic_name) override {
    if (const auto own = handles_.find_participant(local)) own->forget_topic(topic_name);
  }

  Status return_permissions_handle(PermissionsHandle permissions) override {
    const Holder holder = handles_.find(permissions);
    // Hosts return handles of peers more than once, so this raises no event.
    if (!handles_.remove(permissions)) return fail(Code::unknown_permissions_handle);
    if (holder) forget_documents(*holder);
    return {};
  }

  std::uint64_t renewals(PermissionsHandle local) override {
    const Holder holder = handles_.find(local);
    return holder && !holder->remote() ? holder->renewals() : 0;
  }

  Status check_own_endpoint(PermissionsHandle local, bool writes,
                            const EndpointRequest& request) override {
    const Holder holder = handles_.find(local);
    if (!holder || holder->remote()) return fail(Code::unknown_permissions_handle);
    return decisions_.check_endpoint(*holder, writes ? Action::publish : Action::subscribe,
                                     request);
  }

  std::optional<std::size_t> find_unknown_right(PermissionsHandle local,
                                                std::span<const OwnEndpoint> endpoints) override {
    const Holder holder = handles_.find(local);
    if (!holder || holder->remote() || holder->renewals() == 0) return std::nullopt;
    return access_control::find_unknown_right(decisions_, *holder,
                                              handles_.peers_of(*holder->participant()), endpoints);
  }

  std::optional<GovernanceVersion> governance_version(PermissionsHandle local) override {
    const Holder holder = handles_.find(local);
    if (!holder) return {};
    const auto documents = holder->participant()->judging_documents();
    return GovernanceVersion{documents->governance->revision(), documents->governance_digest};
  }
  std::optional<GovernanceVersion> pending_governance(PermissionsHandle local) override {
    const auto own = handles_.find_participant(local);
    const auto pending = own ? own->pending() : nullptr;
    if (!pending) return {};
    return GovernanceVersion{pending->governance->revision(), pending->digest};
  }
  std::optional<spi::ParticipantSecurityAttributes> participant_attributes_of(
      PermissionsHandle local, const GovernanceVersion& version) override {
    const auto rules = governance_of(local, version);
    return rules ? std::optional(participant_attributes(rules->domain_rule())) : std::nullopt;
  }
  std::optional<spi::EndpointSecurityAttributes> endpoint_attributes_of(
      PermissionsHandle local, const GovernanceVersion& version, std::string_view topic) override {
    const auto rules = governance_of(local, version);
    return rules ? topic_attributes(*rules, topic) : std::nullopt;
  }
  bool apply_pending_governance(PermissionsHandle local,
                                const GovernanceVersion& version) override {
    const auto own = handles_.find_participant(local);
    return own && own->apply_pending(version.digest);
  }
  std::optional<RemoteDatareader> pending_permission(PermissionsHandle remote, bool writes,
                                                     const EndpointRequest& request) override;

  std::optional<WallTime> next_expiry() override;
  std::vector<PermissionsHandle> poll(PermissionsHandle local) override;

 private:
  LoadContext context() { return {documents_, options_, services_.clock.calendar_seconds()}; }

  // Raises the one event of a refusal.
  std::unexpected<Error> report_error(const Error& error, const std::string& peer_subject = {},
                                      const std::string& peer_guid = {}) {
    services_.events.raise(event_about(peer_subject, error, peer_guid));
    return std::unexpected(error);
  }

  // Does the same for a call of the application, which gets the error.
  std::unexpected<Error> report_local_error(const Error& error) {
    services_.events.raise(Event::of_returned(error));
    return std::unexpected(error);
  }
  std::unexpected<Error> report_error(const Error& error, const PermissionsHolder& holder) {
    return holder.remote() ? report_error(error, holder.peer_subject()) : report_local_error(error);
  }

  Result<PermissionsHandle> add(Holder holder) {
    auto handle = handles_.add(std::move(holder));
    if (!handle) return report_error(handle.error());
    return handle;
  }

  Result<Holder> find_or_refuse(PermissionsHandle handle) {
    if (Holder holder = handles_.find(handle)) return holder;
    return report_error(Error(Code::unknown_permissions_handle));
  }

  // Finds the holder, lets `judge` decide, and raises an event for a refusal.
  template <class Judge>
  Status check(PermissionsHandle handle, DomainId domain_id, Judge&& judge) {
    DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(handle));
    const DomainId own = holder->participant()->domain;
    const Status status =
        own == domain_id ? judge(*holder)
                         : Status(fail(Code::other_domain, {.expected = std::to_string(own),
                                                            .found = std::to_string(domain_id)}));
    if (!status) return report_error(status.error(), *holder);
    return {};
  }

  std::shared_ptr<const governance::CompiledGovernance> governance_of(
      PermissionsHandle local, const GovernanceVersion& version) {
    const auto own = handles_.find_participant(local);
    return own ? own->governance_of(version.digest) : nullptr;
  }

  void renew_documents(const Entries& all, PermissionsHandle local);
  void note_documents(PermissionsHandle local) noexcept;
  void note_end(const PermissionsHolder& local, const Error& why, WallTime now);
  void forget_documents(const PermissionsHolder& gone);
  Status check_own_match(const PermissionsHolder& remote, const Match& match);
  Result<spi::EndpointSecurityAttributes> attributes(PermissionsHandle local,
                                                     std::string_view topic);

  const PluginServices services_;
  const AccessControlOptions options_;
  const AccessDecisions decisions_;
  DocumentCache documents_;
  HandleTable handles_;
  std::mutex noting_mutex_;  // prevents a participant that has left from being noted again
};

Result<PermissionsHandle> AccessControlPlugin::validate_remote_permissions(
    spi::IdentityHandle local_identity, spi::IdentityHandle remote_identity,
    const spi::Token& permissions_token, const spi::Token& credential) {
  const Holder local = handles_.find_local(local_identity);
  if (!local) return report_error(Error(Code::unknown_local_identity));
  const auto& participant = local->participant();
  // The domain's algorithms apply with and without join access control.
  HolderSubject subject;
  if (const auto status = check_remote_algorithms(*participant, credential, subject); !status)
    return report_error(status.error().with_default_document(participant->governance_name),
                        subject.shown);
  auto judged = judge_remote(context(), *participant, permissions_token, credential, subject);
  const std::string name = subject.shown.empty() ? "permissions of a peer without certificate"
                                                 : "permissions of " + subject.shown;
  std::shared_ptr<PermissionsDocument> document;
  if (judged) {
    document = *std::move(judged);
  } else {
    auto refused = report_error(judged.error().with_default_document(name), subject.shown);
    // Without join access control such a peer may still use unprotected topics.
    if (participant->judging_documents()->governance->domain_rule().enable_join_access_control)
      return refused;
  }
  auto holder = std::make_shared<PermissionsHolder>(participant, remote_identity,
                                                    std::move(subject), name, std::move(document));
  // A peer that keeps its session may continue after the documents that it has seen from us have
  // ended.
  const auto facts = spi::session_facts_in(credential);
  if (!facts.peer_keeps_session) holder->note_seen(local, facts);
  // With this, next_expiry knows the end before the first check. An error comes again at that
  // check.
  if (holder->has_document()) static_cast<void>(decisions_.grant_now(*holder));
  if (const auto listed = holder->follow_list(services_.clock.calendar_seconds()))
    services_.events.raise(event_about(holder->peer_subject(), *listed));
  return add(std::move(holder));
}

Result<bool> AccessControlPlugin::renew_remote_permissions(PermissionsHandle remote,
                                                           const spi::Token& permissions_token,
                                                           const spi::Token& credential) {
  DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(remote));
  const auto& participant = *holder->participant();
  const auto& name = holder->document_name();
  HolderSubject subject;
  if (const auto status = check_remote_algorithms(participant, credential, subject); !status)
    return report_error(status.error().with_default_document(participant.governance_name), *holder);
  auto judged = judge_remote(context(), participant, permissions_token, credential, subject);
  if (!judged) return report_error(judged.error().with_default_document(name), *holder);
  const auto now = services_.clock.calendar_seconds();
  const auto rights = holder->adopt_presented(*std::move(judged), now);
  if (!rights) return report_error(rights.error().with_default_document(name), *holder);
  if (*rights == PresentedRights::same) return false;
  const auto ends = holder->ends();
  const auto shown = ends ? to_string(*ends) : std::string();
  services_.events.raise(event_about(
      holder->peer_subject(), Error(Code::peer_permissions_renewed,
                                    {.document = name, .field = "not_after", .found = shown})));
  return *rights == PresentedRights::fewer;
}

Status AccessControlPlugin::note_presented(PermissionsHandle remote,
                                           const spi::SessionFacts& facts) {
  DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(remote));
  const Holder local = handles_.find_local(holder->participant()->identity);
  if (!local) return report_error(Error(Code::unknown_local_identity));
  if (!facts.peer_keeps_session) holder->note_seen(local, facts);
  return {};
}

// Our endpoint was judged when it was created, but renewed permissions may allow less.
Status AccessControlPlugin::check_own_match(const PermissionsHolder& remote, const Match& match) {
  const Holder own = handles_.find_local(remote.participant()->identity);
  if (!own || own->renewals() == 0) return {};
  const auto action = match.remote_writes ? Action::subscribe : Action::publish;
  const auto status = decisions_.check_endpoint(*own, action, match.local);
  if (!status) return report_error(status.error());
  // The peer refuses the endpoint. Its host would keep the keys of this session for the next one.
  const auto seen = remote.outdated_grant_seen().grant;
  if (!seen || !decisions_.is_denied_by_any({seen}, *own, action, match.local)) return {};
  // No event: nothing is wrong, and own_rights_gained is one.
  return fail(action == Action::publish ? Code::publish_not_allowed : Code::subscribe_not_allowed,
              {.document = "the former permissions, which the peer was shown",
               .field = std::string(match.local.topic_name),
               .note = "the peer learns of the renewed ones when the session begins again",
               .hint = "nothing to do: see own_rights_gained (1451)"});
}

Status AccessControlPlugin::check_remote_match(PermissionsHandle remote, const Match& match) {
  DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(remote));
  DDSSEC_RETURN_IF_ERROR(check_own_match(*holder, match));
  const auto action = match.remote_writes ? Action::publish : Action::subscribe;
  if (!match.remote_hides && decisions_.may_as_announced(*holder, action, match.local)) return {};
  const auto status = decisions_.check_endpoint(*holder, action, match.local);
  if (status) return {};
  const auto guid =
      match.remote ? Guid{*match.remote, kEntityIdParticipant}.to_string() : std::string();
  return report_error(match_denied_error(status.error(), action, match), holder->peer_subject(),
                      guid);
}

Result<spi::AccessControl::RemoteDatareader> AccessControlPlugin::check_remote_datareader(
    PermissionsHandle remote, DomainId domain_id, const EndpointRequest& request) {
  RemoteDatareader answer;
  DDSSEC_RETURN_IF_ERROR(check(remote, domain_id, [&](PermissionsHolder& holder) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(answer, decisions_.check_announced_reader(holder, request));
    return {};
  }));
  return answer;
}

// No event is raised, because nothing is refused before the document is in force.
std::optional<spi::AccessControl::RemoteDatareader> AccessControlPlugin::pending_permission(
    PermissionsHandle remote, bool writes, const EndpointRequest& request) {
  const Holder holder = handles_.find(remote);
  if (!holder || !holder->remote()) return std::nullopt;
  return decisions_.judge_pending(*holder, writes ? Action::publish : Action::subscribe, request);
}

Result<spi::EndpointSecurityAttributes> AccessControlPlugin::attributes(PermissionsHandle local,
                                                                        std::string_view topic) {
  DDSSEC_ASSIGN_OR_RETURN(const Holder holder, find_or_refuse(local));
  auto& participant = *holder->participant();
  const auto used = participant.use_topic(topic);
  if (!used)
    return report_error(used.error().with_default_document(participant.governance_name), *holder);
  if (auto found = topic_attributes(*(*used)->governance, topic)) return *found;
  return report_error(topic_not_covered_error(participant, topic), *holder);
}

std::optional<WallTime> AccessControlPlugin::next_expiry() {
  std::optional<WallTime> earliest;
  for (const auto& [handle, holder] : handles_.all()) {
    const auto end = holder->ends();
    if (end && (!earliest || *end < *earliest)) earliest = end;
  }
  return earliest;
}

// Makes each participant look at its files, at its own interval. Call it before the documents in
// force judge anything. Before one of them ends, all look, for two reasons: participants with the
// same files end together, and a file that came before the end counts.
void AccessControlPlugin::renew_documents(const Entries& all, PermissionsHandle which) {
  Entries own;
  std::ranges::copy_if(all, std::back_inserter(own), [&](const auto& one) {
    return !one.second->remote() && (!which || one.first == which);
  });
  const auto renew = [&] {
    for (const auto& [handle, holder] : own)
      for (const auto& event : holder->renew(documents_, services_.clock))
        services_.events.raise(event_about({}, event));
  };
  renew();
  const WallTime now = services_.clock.calendar_seconds();
  const auto ends = [&](const auto& one) { return one.second->newly_ended(now).has_value(); };
  if (std::ranges::none_of(own, ends)) return;
  for (const auto& [handle, holder] : own) holder->force_poll();
  renew();
}

// Notes the documents for the record that a person reads, if there is one.
void AccessControlPlugin::note_documents(PermissionsHandle local) noexcept {
  if (services_.documents == nullptr) return;
  try {
    const std::scoped_lock lock(noting_mutex_);
    const Holder holder = handles_.find(local);
    if (!holder || holder->remote()) return;
    const auto identity = holder->participant()->identity.value;
    services_.documents->note_participant(identity, {}, holder->subject());
    services_.documents->note(identity, holder->documents(), services_.clock.calendar_seconds());
  } catch (...) {
    // If memory is short, the next look notes them.
  }
}

void AccessControlPlugin::note_end(const PermissionsHolder& local, const Error& why, WallTime now) {
  if (services_.documents != nullptr)
    services_.documents->note_end(local.participant()->identity.value, why, now);
}

void AccessControlPlugin::forget_documents(const PermissionsHolder& gone) {
  constexpr std::array kOwnDocuments = {DocumentKind::permissions_ca, DocumentKind::permissions,
                                        DocumentKind::listed_permissions, DocumentKind::governance};
  if (services_.documents == nullptr || gone.remote()) return;
  const std::scoped_lock lock(noting_mutex_);
  services_.documents->forget(gone.participant()->identity.value, kOwnDocuments);
}

std::vector<PermissionsHandle> AccessControlPlugin::poll(PermissionsHandle local) {
  const auto all = handles_.all();
  const Holder own = handles_.find(local);
  renew_documents(all, local);
  const auto own_or_peer = [&](const auto& one) {
    return !local || (own && own->participant() == one.second->participant());
  };
  Entries judged;
  std::ranges::copy_if(all, std::back_inserter(judged), own_or_peer);
  follow_renewal_lists(judged, documents_, services_);
  for (const auto& [handle, holder] : all)
    if (!local || handle == local) note_documents(handle);
  const WallTime now = services_.clock.calendar_seconds();
  // If there is not enough memory to report them, none is marked: the next call finds them again.
  std::vector<PermissionsHandle> ended;
  Participants gone;
  std::vector<std::pair<Event, PermissionsHolder*>> reasons;
  std::vector<Error> warnings;
  for (const auto& [handle, holder] : judged) {
    if (!holder->remote())
      if (const auto soon = holder->ends_soon(now)) warnings.push_back(*soon);
    const auto reason = holder->newly_ended(now);
    if (!reason) continue;
    ended.push_back(handle);  // pushing here keeps the order
    if (!holder->remote()) {
      gone.insert(holder->participant().get());
      note_end(*holder, *reason, now);
    }
    reasons.emplace_back(event_about(holder->peer_subject(), *reason), holder.get());
  }
  if (!gone.empty())
    std::ranges::set_difference(peers_of_only(gone, all, now), std::vector(ended),
                                std::back_inserter(ended));
  for (const auto& warning : warnings) services_.events.raise(event_about({}, warning));
  // The steps that need no memory come last, so that every participant that is marked was reported.
  for (const auto& [event, holder] : reasons) services_.events.raise(event);
  for (const auto& [event, holder] : reasons) holder->mark_reported();
  return ended;
}

}  // namespace

std::unique_ptr<spi::AccessControl> make_access_control(const PluginServices& services,
                                                        AccessControlOptions options) {
  return std::make_unique<AccessControlPlugin>(services, std::move(options));
}

}  // namespace ddssec::access_control
