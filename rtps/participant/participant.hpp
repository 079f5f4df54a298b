// The protocol side of a participant (RTPS 8): it is told of datagrams and of time, and sends
// through a transport; no socket, clock, thread or lock. Wires the parts, which do the work:
//
//   MessageReceiver    walks what arrives, by EndpointLookup and MessageListener
//   Discovery          finds participants and endpoints, and believes them or not
//   Announcer          announces this participant
//   WriterLiveliness   says that our writers live, hears whether others do
//   EndpointMatcher    which endpoints match, and why not; BuiltinMatcher for the builtin ones
//   LocalEndpoints     our writers and readers, and their announcements
//   RemoteParticipants what is known of others, and the bounds on it
//   ParticipantCore    what all of them use
//
// Each calls only those below it; MessageReceiver and Security call Discovery by their interfaces.
#pragma once

#include "rtps/participant/deferred_calls.hpp"
#include "rtps/participant/discovery.hpp"
#include "rtps/participant/endpoint_directory.hpp"
#include "rtps/participant/message_receiver.hpp"

namespace ddssec::rtps {

class Participant {
 public:
  static constexpr unsigned kMostBacklog = 16;  ///< batches that are read before anything is due

  /// `transport` and `events` are borrowed.
  Participant(ParticipantConfig config, Transport& transport, EventSink& events);

  /// Makes it a secured one, before anything else happens; the prefix must be that of `own`.
  /// Errors: those of the plugins.
  Status secure(std::unique_ptr<OwnSecurity> own);

  const GuidPrefix& prefix() const { return core_.config.prefix; }
  const ParticipantCounters& counters() const { return core_.counters; }
  /// All zero without security.
  ProtectionCounters protection_counters() const;
  AuthenticationCounters authentication_counters() const;
  bool is_authenticated(const GuidPrefix& peer) const { return core_.is_authenticated(peer); }
  const LocalEndpoints& local_endpoints() const { return local_; }
  const RemoteParticipants& remote_participants() const { return remotes_; }

  /// Samples may wait a moment for others, as tick is called whenever next_tick says so.
  void allow_lingering() { core_.sender.allow_lingering(); }
  /// While it lives, what is to be sent waits for its end and shares messages.
  MessageSender::Gathering gather() { return MessageSender::Gathering(core_.sender); }
  /// One datagram. `source`: where it came from, as room for what proves nothing is shared by it.
  void receive(BytesView datagram, MonotonicTime now, const Locator& source = {});
  /// Told after each batch of datagrams: more wait to be received. The answers to what we would
  /// repeat may be among them, so nothing is due before they are read, or many batches of them.
  void note_backlog(bool any) {
    backlog_ = any ? backlog_ + 1 : 0;
    reads_first_ = backlog_ % kMostBacklog != 0;
  }
  /// Whatever is due: announcements, heartbeats, leases.
  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;
  /// Disposes the participant, by which the others know that it leaves.
  void leave() { announcer_.leave(remotes_); }

  /// Errors: rtps_qos_inconsistent, and if it is secured those of access control.
  Result<Guid> create_writer(EndpointRequest request, EndpointListener& listener,
                             MonotonicTime now);
  Result<Guid> create_reader(EndpointRequest request, EndpointListener& listener,
                             MonotonicTime now);
  /// Also tells the others.
  void remove(const Guid& endpoint, MonotonicTime now);
  /// A name for a publisher.
  Guid create_group() { return local_.create_group(); }

  /// Announces other policies of an endpoint of ours and matches it anew. Which ones may change is
  /// the caller's business. Errors: rtps_qos_inconsistent.
  Status change_qos(const Guid& endpoint, Qos qos, MonotonicTime now);
  /// Announces another content filter of a reader of ours.
  void change_filter(const Guid& reader, ContentFilterProperty filter, MonotonicTime now);
  /// Announces other user data of the participant, soon.
  void change_user_data(Bytes user_data);

  /// Tells all that our writers of this kind live (RTPS 8.4.13). Those of kind AUTOMATIC are
  /// asserted by tick.
  void assert_liveliness(LivelinessKind kind, MonotonicTime now);
  /// See Security.
  Status revise_keys();

  /// See RemoteParticipants.
  void listen(DiscoveryListener* listener);
  /// Any remote endpoint on that topic.
  std::optional<EndpointData> endpoint_on(const std::string& topic_name) const {
    return matcher_.endpoint_on(topic_name);
  }
  /// For good: as if it had never been found. Our own prefix: our endpoints ignore each other. From
  /// within a callback what is known of it goes when the call that led there is over.
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
  unsigned backlog_ = 0;      ///< batches since there was none
  bool reads_first_ = false;  ///< before the next tick counts
  DeferredCalls calls_;
};

}  // namespace ddssec::rtps
