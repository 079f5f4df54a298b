// Finds other participants and removes them (RTPS 8.5.3), receives announcements of their endpoints
// (RTPS 8.5.4), and applies the decisions of security to them (DDS-Security 1.2, clauses 7.5
// and 9.8).
#pragma once

#include "rtps/participant/announcer.hpp"
#include "rtps/participant/clear_announcements.hpp"
#include "rtps/participant/endpoint_lookup.hpp"
#include "rtps/participant/participant_links.hpp"
#include "rtps/participant/proven_refreshes.hpp"
#include "rtps/participant/resting_participants.hpp"
#include "rtps/participant/writer_liveliness.hpp"

namespace ddssec::rtps {

/// Decides which messages to trust, and calls the other parts to act on them. The other parts do
/// not know this class.
class Discovery final : public MessageListener, public SecurityHost {
 public:
  /// The caller owns the parts; they must outlive this object.
  struct Parts {
    LocalEndpoints& local;
    RemoteParticipants& remotes;
    EndpointMatcher& matcher;
    WriterLiveliness& liveliness;
    Announcer& announcer;
  };
  Discovery(ParticipantCore& core, const Parts& parts);

  /// Called with each change that arrives for a builtin reader.
  void on_builtin(BuiltinTopic topic, const Change& change);
  /// Removes a participant, as if it had never been found.
  void remove(const GuidPrefix& prefix) { links_.remove(prefix); }
  /// Which addresses of this machine have changed. After `all`, no other participant can reach this
  /// one any more.
  enum class ChangedAddresses : std::uint8_t { some, all };
  /// Chooses addresses again, because other addresses of the participants may be nearest. After
  /// `all`, removes the participants.
  void on_addresses_changed(ChangedAddresses changed);
  /// Removes participants that left, when none of their data is being processed any more. Brings
  /// back dormant ones that have answered.
  void remove_gone();
  /// Also removes participants whose leases have ended, and queries those whose leases end soon.
  void tick();

  // MessageListener:
  Status on_announcement(const GuidPrefix& source, const Data& data) override;
  void on_stateless(const GuidPrefix& source, BytesView payload) override;
  void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag) override;
  void on_builtin_heartbeat(const Guid& writer) override;
  void on_alive(const Guid& writer) override { parts_.liveliness.note_alive(writer); }
  void on_acknack(const GuidPrefix& source, const AckNack& acknack, bool is_protected) override;
  void on_key_exchange(const GuidPrefix& source) override;
  void on_message(const GuidPrefix& source, const SignsOfLife& signs) override;

  // SecurityHost:
  void on_authenticated(const GuidPrefix& peer) override;
  void on_unauthenticated(const GuidPrefix& peer) override;
  LocatorList on_proven(const GuidPrefix& peer, const ParticipantData& proven) override;
  void on_unconfirmed(const GuidPrefix& peer) override;
  void on_replaced(const GuidPrefix& peer) override;
  void on_keys(const EntityId& local, const Guid& remote) override;
  void on_early_keys(const EntityId& local, const Guid& remote) override;
  void on_key_change(const EntityId& local, const Guid& remote, KeyChange change) override {
    parts_.local.note_key_change(local, remote, change);
    if (change == KeyChange::former_ended) proven_.read_again(remote.prefix);
  }
  bool on_rights_changed(const GuidPrefix& peer) override;
  void on_ended(const GuidPrefix& peer) override { gone_.push_back(peer); }

 private:
  /// Adds a participant. `octets` is the size of its announcement.
  void add(ParticipantData data, std::size_t octets);
  void on_announced_again(RemoteParticipant& remote, ParticipantData data, std::size_t octets);
  void on_dispose(const GuidPrefix& prefix);
  /// Accepts a participant that authenticated. If it returns, the facts known about it still count.
  void join(RemoteParticipant& remote, bool returns);
  void on_endpoint(BuiltinTopic topic, const Change& change);
  void on_secure_participant(const Change& change);

  ParticipantCore& core_;
  const Parts parts_;
  BuiltinMatcher builtin_;
  ParticipantLinks links_;
  ClearAnnouncements clear_;
  ProvenRefreshes proven_;
  RestingParticipants resting_;
  std::vector<GuidPrefix> gone_;
};

}  // namespace ddssec::rtps
