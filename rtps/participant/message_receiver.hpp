// Processes received messages (RTPS 8.3.4): decrypts and verifies protected parts, and passes each
// submessage to the endpoints that it is addressed to. EndpointLookup finds them.
#pragma once

#include <functional>

#include "rtps/participant/endpoint_lookup.hpp"
#include "rtps/participant/participant_counters.hpp"
#include "rtps/security/keyring.hpp"
#include "wire/message_reader.hpp"

namespace ddssec::rtps {

class MappedMemory;

/// The Receiver of RTPS 8.3.4 for one participant. It keeps no state from one message to the next,
/// except buffers.
class MessageReceiver {
 public:
  /// Reports a message that cannot be read. `source` is the participant; it is zero if not even the
  /// header can be read.
  using Report =
      std::function<void(const GuidPrefix& source, const Error& error, EventOrigin origin)>;
  /// Everything is borrowed and must outlive the receiver.
  MessageReceiver(const GuidPrefix& own, EndpointLookup& endpoints, MessageListener& listener,
                  ParticipantCounters& counters, Report report);

  /// Opens messages with these keys from now on. A submessage that is not protected as the
  /// governance requires is dropped.
  void open_with(Keyring& keyring);
  /// Takes payloads also from the memory of writers from now on, or no longer if `memory` is
  /// nullptr.
  void fetch_from(MappedMemory* memory) { memory_ = memory; }
  /// Processes one datagram from an untrusted source. Parts that cannot be read are counted and
  /// reported.
  void receive(BytesView datagram, MonotonicTime now);

 private:
  /// The state that earlier submessages of a message set for later ones (RTPS 8.3.4).
  struct Context {
    GuidPrefix source;
    bool is_for_us = true;    ///< INFO_DST names this participant, or none
    bool is_from_us = false;  ///< INFO_SRC names this participant
    std::optional<Time> time = {};
    MonotonicTime now{};
    std::size_t message_size = 0;
    ReceivedProtection opened_by = {};
    SignsOfLife signs = {};

    /// True if the submessages count. Messages in the name of this participant do not: its own
    /// endpoints reach each other directly.
    bool counts() const { return is_for_us && !is_from_us; }
    /// True if keys of the source protect the submessage. A source of zeros has none: it is not the
    /// prefix of an endpoint that is not set.
    bool is_protected() const {
      return opened_by.message || (!source.is_zero() && opened_by.submessage.prefix == source);
    }
    /// Notes that an endpoint received a submessage. `is_new` means that it had not received it
    /// before.
    void note_received(bool is_new) { note_received(is_new, is_protected()); }
    /// `is_proof` means that only the source can have sent it, and not before.
    void note_received(bool is_new, bool is_proof) {
      signs.is_news |= is_new;
      signs.is_proof |= is_new && is_proof;
    }
  };

  void read(const Header& header, BytesView datagram, MonotonicTime now);
  /// Reports to the listener what the submessages of the current source show about it. Called after
  /// the last submessage of each source.
  void report(Context& context);
  Status walk(BytesView message, Context& context);
  Status open_group(const SubmessageView& prefix, MessageReader& message, Context& context);
  Status process(const SubmessageView& view, Context& context);
  Status process_info(const SubmessageView& view, Context& context);
  Status on_data(const SubmessageView& view, Context& context);
  /// Handles a DATA whose payload is in shared memory.
  Status on_reference(const Data& data, Context& context);
  Status on_data_frag(const SubmessageView& view, Context& context);
  Status on_heartbeat(const SubmessageView& view, Context& context);
  Status on_gap(const SubmessageView& view, Context& context);
  Status on_acknack(const SubmessageView& view, Context& context);
  Status on_nack_frag(const SubmessageView& view, Context& context);
  /// Calls `f(StatefulReader&)` for each reader that the writer matched, if the submessage is
  /// protected as that reader requires.
  template <class F>
  void each_reader(const EntityId& reader, const EntityId& writer, const Context& context, F&& f);
  /// Returns the local writer that a reader addresses, or nullptr if there is none, or if the
  /// submessage is not protected as the writer requires.
  StatefulWriter* addressed(const EntityId& writer, const EntityId& reader, const Context& context);
  bool accepts(const EntityId& local, const Guid& remote, const Context& context);
  /// True if keys of the reader's participant protect what the reader sent, and show that it was
  /// meant for this writer.
  bool is_for(const EntityId& writer, const EntityId& reader, const Context& context) const;
  /// True for a dispose or unregister without a payload, if its writer would have sent one, and for
  /// a payload that lacks the mark of its change (end_mark).
  bool is_refused(const EntityId& reader, const Guid& writer, const Data& plain,
                  const Context& context);
  /// True if only the payload is proven, and says by its mark whether it ends an instance.
  bool is_marked(const EntityId& reader, const Guid& writer, const Context& context);
  /// Returns the time at which a sample with this inline QoS was written.
  std::optional<Time> source_time(const Context& context, const InlineQos& inline_qos) const;
  /// Returns the payload without its protection; empty if it cannot be opened.
  std::optional<BytesView> opened(const StatefulReader& reader, const Guid& writer,
                                  BytesView payload, const ReceivedProtection& opened_by);
  /// As opened above, for a payload from shared memory.
  Payload opened(const StatefulReader& reader, const Guid& writer, const Payload& payload,
                 const ReceivedProtection& opened_by);

  const GuidPrefix own_;
  EndpointLookup& endpoints_;
  MessageListener& listener_;
  ParticipantCounters& counters_;
  const Report report_;
  Keyring* keyring_ = nullptr;  ///< nullptr if the participant is not secured
  MappedMemory* memory_ = nullptr;
  Bytes message_scratch_, submessage_scratch_, payload_scratch_;
};

}  // namespace ddssec::rtps
