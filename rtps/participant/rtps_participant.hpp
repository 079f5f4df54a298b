// The protocol side of a participant (RTPS 8). Its caller passes in datagrams and times, and it
// sends through a transport. It has no socket, clock, thread or lock. It connects these parts,
// which do the work:
//
//   MessageReceiver    processes messages, through EndpointLookup and MessageListener
//   Discovery          finds participants and endpoints, and decides whether to trust them
//   Announcer          announces the local participant
//   WriterLiveliness   asserts the liveliness of local writers and tracks that of remote ones
//   EndpointMatcher    matches user endpoints; BuiltinMatcher matches builtin ones
//   LocalEndpoints     the local writers and readers, and their announcements
//   RemoteParticipants what is known of remote participants, and the limits on it
//   ParticipantCore    is used by all of them
//
// Each part calls only those below it. MessageReceiver and Security call Discovery through
// interfaces.
#pragma once

#include "rtps/participant/deferred_calls.hpp"
#include "rtps/participant/discovery.hpp"
#include "rtps/participant/endpoint_directory.hpp"
#include "rtps/participant/message_receiver.hpp"
#include "rtps/participant/own_change.hpp"

namespace ddssec::rtps {

/// One participant of the protocol. Not thread-safe: the caller serializes calls.
class RtpsParticipant {
 public:
  /// The number of batches that are read before due work is done.
  static constexpr unsigned kMaxBacklog = 16;

  /// `transport` and `events` are borrowed and must outlive the participant.
  RtpsParticipant(ParticipantConfig config, Transport& transport, EventSink& events);

  /// Makes it a secured participant. Call it before all others; the GUID prefix must be that
  /// of `own`. Errors: those of the plugins.
  Status enable_security(std::unique_ptr<OwnSecurity> own);

  const GuidPrefix& prefix() const { return core_.config.prefix; }
  const ParticipantCounters& counters() const { return core_.counters; }
  /// Both are all zero without security.
  ProtectionCounters protection_counters() const;
  AuthenticationCounters authentication_counters() const;
  bool is_authenticated(const GuidPrefix& peer) const { return core_.is_authenticated(peer); }
  const LocalEndpoints& local_endpoints() const { return local_; }
  const RemoteParticipants& remote_participants() const { return remotes_; }

  /// Allows samples to wait briefly for others, if the caller calls tick whenever next_tick
  /// requires it.
  void allow_delayed_flush() { core_.sender.allow_delayed_flush(); }
  /// As long as the returned object exists, messages are collected; they are sent together when it
  /// is destroyed.
  MessageSender::GatheringScope gather() { return MessageSender::GatheringScope(core_.sender); }
  /// Processes one datagram. `source` is the address that it came from, which limits how much
  /// unproven data one address can store.
  void receive(BytesView datagram, MonotonicTime now, const Locator& source = {});
  /// Call it after each batch of datagrams. `has_backlog` means that more datagrams wait to
  /// be received. Some of them may be answers, without which messages would be repeated. So no work
  /// is due before they have been read, or before many batches have been read.
  void note_backlog(bool has_backlog) {
    backlog_ = has_backlog ? backlog_ + 1 : 0;
    reads_first_ = backlog_ % kMaxBacklog != 0;
  }
  /// Does what is due: announcements, HEARTBEATs, leases.
  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;
  /// Disposes the participant, so that peers know that it leaves.
  void leave() { announcer_.leave(remotes_); }

  /// Creates an endpoint. Errors: rtps_qos_inconsistent, and for a secured participant those of
  /// access control.
  Result<Guid> create_writer(EndpointDescription request, EndpointListener& listener,
                             MonotonicTime now);
  Result<Guid> create_reader(EndpointDescription request, EndpointListener& listener,
                             MonotonicTime now);
  /// Removes the endpoint and its announcement.
  void remove(const Guid& endpoint, MonotonicTime now);
  /// Creates a GUID for a publisher.
  Guid create_group() { return local_.create_group(); }

  /// Announces changed policies of a local endpoint and matches it again. The caller must check
  /// which other policies may change. If a writer goes to other partitions, keys are revised.
  /// Errors: rtps_qos_inconsistent, those of check_partition_change.
  Status change_qos(const Guid& endpoint, Qos qos, MonotonicTime now);
  /// Announces a changed content filter of a local reader.
  void change_filter(const Guid& reader, ContentFilterProperty filter, MonotonicTime now);

  /// Changes the data of the participant itself, and announces it soon.
  void change_own(OwnChange change, MonotonicTime now);

  /// Asserts the liveliness of the local writers of this kind to all participants (RTPS 8.4.13).
  /// tick does this for kind AUTOMATIC.
  void assert_liveliness(LivelinessKind kind, MonotonicTime now);
  /// Creates new keys for the peers that are trusted now (Security::revise_keys). Errors:
  /// rtps_key_revision_disabled, which is also returned without security.
  Status revise_keys();

  /// Reports remote participants and endpoints to `listener`; with nullptr, stops reporting
  /// (RemoteParticipants).
  void set_discovery_listener(DiscoveryListener* listener);
  /// Returns any remote endpoint on that topic.
  std::optional<EndpointData> endpoint_on(const std::string& topic_name) const {
    return matcher_.endpoint_on(topic_name);
  }
  /// Ignores the entity permanently, as if it had never been found. With the local prefix, the
  /// local endpoints ignore each other. If called from within a callback, the data about the entity
  /// is removed when the outermost call ends.
  void ignore_participant(const GuidPrefix& prefix);
  void ignore_endpoint(const Guid& guid);
  void ignore_topic(const std::string& name);

 private:
  ParticipantCore core_;
  RemoteParticipants remotes_{core_};
  LocalEndpoints local_;
  EndpointMatcher matcher_{core_, local_, remotes_};
  WriterLiveliness liveliness_{core_, local_, remotes_};
  Announcer announcer_{core_, local_.builtin()};
  Discovery discovery_{core_, {local_, remotes_, matcher_, liveliness_, announcer_}};
  EndpointDirectory directory_{core_, local_, remotes_};
  MessageReceiver receiver_{prefix(), directory_, discovery_, core_.counters,
                            [this](const auto& source, const auto& error, auto origin) {
                              core_.raise(error, source, source.is_zero() ? "" : source.to_string(),
                                          origin);
                            }};
  unsigned backlog_ = 0;      ///< number of batches since there was no backlog
  bool reads_first_ = false;  ///< true if the backlog is read before tick does anything
  DeferredCalls calls_;
};

}  // namespace ddssec::rtps
