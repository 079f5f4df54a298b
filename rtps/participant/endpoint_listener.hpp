// The interface between a local endpoint and its owner: the description with which the owner
// creates it, and the notifications that the owner receives.
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/participant/liveliness_signal.hpp"
#include "rtps/qos/matching.hpp"
#include "rtps/reliability/change.hpp"
#include "rtps/reliability/held_octets.hpp"
#include "rtps/reliability/key_payload.hpp"

namespace ddssec::rtps {

class ChangeFilter;

/// Receives notifications for one local endpoint. Called from within receive, tick, create and
/// remove.
class EndpointListener {
 public:
  virtual ~EndpointListener() = default;
  /// Called again for a remote endpoint that is already matched when it announces changed policies.
  virtual void on_matched(const EndpointData& remote) = 0;
  virtual void on_unmatched(const Guid& remote) = 0;
  virtual void on_incompatible_qos(const Guid& remote, const QosMismatch& mismatch) = 0;
  /// Called if the remote endpoint has the same topic name but another type, or if only one side
  /// has keys.
  virtual void on_inconsistent_topic(const EndpointData& remote) = 0;
  /// Readers only: takes the change or refuses it for now (see StatefulReader::Deliver).
  virtual bool on_change(Change&) { return true; }
  /// Readers only: this many changes of a writer will never arrive.
  virtual void on_sample_lost(std::int64_t) {}
  /// Readers only: a change of this many octets was given up, because it is larger than readers
  /// accept.
  virtual void on_sample_dropped(const Guid&, std::uint32_t) { on_sample_lost(1); }
  /// Readers only: the matched writer offers a finite lease_duration and is asserted by this
  /// signal, together with others. nullptr means that only on_alive asserts it (MANUAL_BY_TOPIC).
  /// Called after on_matched.
  virtual void on_signal(const Guid&, std::shared_ptr<LivelinessSignal>) {}
  /// Readers only: the matched writer asserted its liveliness. Called for a MANUAL_BY_TOPIC writer
  /// with a finite lease_duration, or if the reader requested it with LivelinessSignal::notify.
  virtual void on_alive(const Guid&) {}
  /// Readers only: the writer has delivered everything up to this group sequence number.
  virtual void on_group(const Guid&, SequenceNumber) {}
  /// Writers only: there may be room again.
  virtual void on_acknowledged() {}
  /// Called if the payloads and the keys in them are encrypted (DDS-Security 1.2, clause 7.4.4),
  /// before any other notification.
  virtual void on_key_protected() {}
  /// Called if the payloads are protected, so that their contents are proven, but the key hash next
  /// to them is not. Called before any other notification.
  virtual void on_payload_protected() {}
  /// Writers only: returns the filter for the samples that are sent to a matching reader, or
  /// nullptr if it has none. Called before on_matched, and again whenever the reader announces
  /// itself again.
  virtual std::shared_ptr<ChangeFilter> filter_for(const EndpointData&) { return nullptr; }
};

/// The data that is announced of a new endpoint.
struct EndpointDescription {
  std::string topic_name;
  std::string type_name;
  Qos qos;
  bool with_key = true;
  TypeDescription type = {};
  std::optional<ContentFilterProperty> content_filter = {};  ///< readers only
  /// Readers only: the octets that are held count together with those of others
  /// (StatefulReader::share_held). If it is empty, they count for this reader alone.
  std::shared_ptr<HeldOctets> held = {};
  /// Writers only: earlier changes, for readers that request history.
  std::vector<Change> history = {};
  bool is_history_only = false;    ///< writers only: see StatefulWriter::serve_history_only
  std::optional<Guid> group = {};  ///< the GUID of a publisher with GROUP access
  KeyRewriter bare_key = {};       ///< writers only: see StatefulWriter::rewrite_keys_with
};

}  // namespace ddssec::rtps
