// What the owner of an endpoint asks for, and what it is told.
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/participant/liveliness_signal.hpp"
#include "rtps/qos/matching.hpp"
#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

/// What a local endpoint's owner is told. Called from within receive, tick, create and remove.
class EndpointListener {
 public:
  virtual ~EndpointListener() = default;
  /// Again for a remote that is matched already, when it announced changed policies.
  virtual void on_matched(const EndpointData& remote) = 0;
  virtual void on_unmatched(const Guid& remote) = 0;
  virtual void on_incompatible_qos(const Guid& remote, const QosMismatch& mismatch) = 0;
  /// The same topic name with another type, or with keys on one side only.
  virtual void on_inconsistent_topic(const EndpointData& remote) = 0;
  /// A reader's: takes the change or refuses it for now (see StatefulReader::Deliver).
  virtual bool on_change(Change&) { return true; }
  /// A reader's: so many changes of a writer will never come.
  virtual void on_sample_lost(std::int64_t) {}
  /// A reader's: a change of so many octets was given up, as it is larger than readers take.
  virtual void on_sample_dropped(const Guid&, std::uint32_t) { on_sample_lost(1); }
  /// A reader's: the matched writer, which offers a finite lease_duration, is asserted together
  /// with others, by this signal. nullptr: by on_alive alone (MANUAL_BY_TOPIC). After on_matched.
  virtual void on_signal(const Guid&, std::shared_ptr<LivelinessSignal>) {}
  /// A reader's: the matched writer, of MANUAL_BY_TOPIC and a finite lease_duration, asserted
  /// itself; or the reader asked LivelinessSignal::notify for it.
  virtual void on_alive(const Guid&) {}
  /// A reader's: the writer has nothing undelivered up to that group sequence number.
  virtual void on_group(const Guid&, SequenceNumber) {}
  /// A writer's: there may be room again.
  virtual void on_acknowledged() {}
  /// Its payloads are encrypted, and with them its keys (DDS-Security 7.4.4). Said before anything
  /// else.
  virtual void on_key_protected() {}
  /// Its payloads are protected: what they say is proven, and the key hash beside them is not. Said
  /// before anything else.
  virtual void on_payload_protected() {}
  /// A writer's: what keeps a matching reader's samples from being sent to it; nullptr: nothing.
  /// Asked before on_matched, and again whenever the reader announces itself anew.
  virtual std::shared_ptr<ChangeFilter> filter_for(const EndpointData&) { return nullptr; }
};

/// What is announced of a new endpoint.
struct EndpointRequest {
  std::string topic_name;
  std::string type_name;
  Qos qos;
  bool with_key = true;
  TypeDescription type = {};
  std::optional<ContentFilterProperty> content_filter = {};  ///< a reader's
  std::vector<Change> history = {};  ///< a writer's, from before: only for readers that want it
  bool history_only = false;         ///< a writer's: see StatefulWriter::serve_history_only
  std::optional<Guid> group = {};    ///< of a publisher with GROUP access
  KeyRewriter bare_key = {};         ///< a writer's: see StatefulWriter::rewrite_keys_with
};

}  // namespace ddssec::rtps
