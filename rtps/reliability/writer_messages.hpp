// What a writer says: DATA, DATA_FRAG, GAP and HEARTBEAT (RTPS 8.3.8).
#pragma once

#include "rtps/reliability/key_payload.hpp"
#include "rtps/reliability/message_sender.hpp"
#include "rtps/reliability/writer_history.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/inline_qos.hpp"

namespace ddssec::rtps {

/// What the writers of one publisher with GROUP access have in common.
struct WriterGroup {
  SequenceNumber current;  ///< group sequence number that was given last; 0 none
  GroupDigest writers = {};
};

/// Adds submessages to the sender, which is flushed by the caller. The sender and the history
/// outlive it.
class WriterMessages {
 public:
  static constexpr std::uint32_t kAllFragments = ~0u;

  WriterMessages(const EntityId& writer, DurabilityKind durability, MessageSender& sender,
                 const WriterHistory& history)
      : writer_(writer), durability_(durability), sender_(sender), history_(history) {}

  /// For readers that read keys of the writer's type in one layout only.
  void rewrite_keys_with(KeyRewriter to_bare) { to_bare_key_ = std::move(to_bare); }
  /// How the keys that are sent from now on are read.
  void set_key_reading(const KeyReading& reading) { key_reading_ = reading; }
  /// Heartbeats and gaps tell where the writer stands in the group, which outlives it.
  void join(const WriterGroup& group) { group_ = &group; }

  /// Of the fragments that are sent.
  std::uint16_t fragment_size() const { return sender_.fragment_size(); }

  /// In DATA, or if it is too large in DATA_FRAG, and then the first `max_fragments`. `filters`:
  /// what the receivers' content filters say of it.
  void change(const Receiver& receiver, const Change& change,
              std::span<const FilterResult> filters = {},
              std::uint32_t max_fragments = kAllFragments);
  void fragment(const Receiver& receiver, const Change& change, FragmentNumber number,
                std::span<const FilterResult> filters = {});
  /// Changes first .. end - 1 are irrelevant.
  void gap(const Receiver& receiver, SequenceNumber first, SequenceNumber end);
  /// Of changes from `first` to the last that was written. Final: no answer is needed.
  void heartbeat(const Receiver& receiver, SequenceNumber first, bool is_final,
                 bool asserts_liveliness = false);

 private:
  /// What of a change is sent.
  BytesView payload_of(const Change& change);
  InlineQos inline_qos_of(const Change& change, std::span<const FilterResult> filters) const;
  std::optional<GroupState> group_state() const;

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
