// The messages of a writer: DATA, DATA_FRAG, GAP and HEARTBEAT (RTPS 8.3.8).
#pragma once

#include "rtps/reliability/key_payload.hpp"
#include "rtps/reliability/message_sender.hpp"
#include "rtps/reliability/writer_group.hpp"
#include "rtps/reliability/writer_history.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/inline_qos.hpp"

namespace ddssec::rtps {

/// The flags of a HEARTBEAT that its sender chooses.
struct HeartbeatFlags {
  bool is_final = false;  ///< no answer is needed
  bool asserts_liveliness = false;
};

/// Adds submessages to the sender, which the caller flushes. The sender and the history must
/// outlive this object.
class WriterMessages {
 public:
  static constexpr std::uint32_t kAllFragments = ~0u;

  WriterMessages(const EntityId& writer, DurabilityKind durability, MessageSender& sender,
                 const WriterHistory& history)
      : writer_(writer), durability_(durability), sender_(sender), history_(history) {}

  /// Sets the function for readers that can read keys of the writer's type only in one layout.
  void rewrite_keys_with(KeyRewriter to_bare) { to_bare_key_ = std::move(to_bare); }
  /// Sets how readers interpret the keys that are sent from now on.
  void set_key_reading(const KeyReading& reading) { key_reading_ = reading; }
  /// Makes HEARTBEATs and GAPs include the writer's position in the group. `group` must outlive
  /// this object.
  void join(const WriterGroup& group) { group_ = &group; }

  /// Returns the size of the fragments that are sent, in octets.
  std::uint16_t fragment_size() const { return sender_.fragment_size(); }

  /// Sends a change in DATA or, if it is too large, its first `max_fragments` fragments in
  /// DATA_FRAG. No fragments are written for which AmplificationLimit leaves the receiver nothing.
  /// `filters` has the results of the receivers' content filters.
  void change(const Receiver& receiver, const Change& change,
              std::span<const FilterResult> filters = {},
              std::uint32_t max_fragments = kAllFragments);
  /// Sends a change whose payload the receivers find in memory.
  void reference(const Receiver& receiver, const Change& change, const MemoryReference& memory,
                 std::span<const FilterResult> filters = {});
  void fragment(const Receiver& receiver, const Change& change, FragmentNumber number,
                std::span<const FilterResult> filters = {});
  /// Declares changes first .. end - 1 irrelevant.
  void gap(const Receiver& receiver, SequenceNumber first, SequenceNumber end);
  /// Announces the changes from `first` to the last that was written.
  void heartbeat(const Receiver& receiver, SequenceNumber first, HeartbeatFlags flags);

 private:
  /// Returns the payload of a change as it is sent, without the mark of its end.
  BytesView payload_of(const Change& change);
  /// Returns `beginning`, the first octets of what payload_of returned, with the mark of the end of
  /// the change if it needs one (end_mark).
  BytesView marked(const Change& change, BytesView beginning);
  InlineQos inline_qos_of(const Change& change, std::span<const FilterResult> filters) const;
  std::optional<HeartbeatGroupInfo> group_state() const;

  const EntityId writer_;
  const DurabilityKind durability_;
  KeyReading key_reading_;
  std::int32_t heartbeat_count_ = 0;
  MessageSender& sender_;
  const WriterHistory& history_;
  const WriterGroup* group_ = nullptr;
  KeyRewriter to_bare_key_;
  Bytes key_scratch_;
};

}  // namespace ddssec::rtps
