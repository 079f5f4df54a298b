// The stateful builtin endpoints of a participant: SEDP, participant messages and, if it is
// secured, their secure counterparts (RTPS 8.5.4, DDS-Security 1.2, clause 7.5.8).
#pragma once

#include <array>
#include <memory>
#include <span>

#include "rtps/reliability/stateful_reader.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {

/// The limits for announcements that discovery keeps because they arrived early or incomplete. They
/// are for all participants together.
inline constexpr StatefulReader::Limits kBuiltinLimits{.largest_sample = 256 << 10,
                                                       .held_octets = std::size_t{16} << 20};

/// The topics of the stateful builtin endpoints; the secure ones last.
enum class BuiltinTopic : std::uint8_t {
  publications,
  subscriptions,
  participant_message,
  publications_secure,
  subscriptions_secure,
  participants_secure,
  participant_message_secure,
};

/// True for the topics that only authenticated participants can publish.
constexpr bool is_secure(BuiltinTopic topic) { return topic >= BuiltinTopic::publications_secure; }
/// True for the two topics that announce writers.
constexpr bool is_of_writers(BuiltinTopic topic) {
  return topic == BuiltinTopic::publications || topic == BuiltinTopic::publications_secure;
}

/// One row: a topic, its writer and reader, and their bits in BuiltinEndpointSet_t.
struct BuiltinTopicInfo {
  BuiltinTopic topic;
  EntityId writer, reader;
  std::uint32_t bits;
  bool is_secure;
};

inline constexpr std::array kBuiltinTopics = {
    BuiltinTopicInfo{BuiltinTopic::publications, kPublicationsWriter, kPublicationsReader,
                     builtin_endpoints::kPublications, false},
    BuiltinTopicInfo{BuiltinTopic::subscriptions, kSubscriptionsWriter, kSubscriptionsReader,
                     builtin_endpoints::kSubscriptions, false},
    BuiltinTopicInfo{BuiltinTopic::participant_message, kParticipantMessageWriter,
                     kParticipantMessageReader, builtin_endpoints::kParticipantMessage, false},
    BuiltinTopicInfo{BuiltinTopic::publications_secure, kPublicationsSecureWriter,
                     kPublicationsSecureReader, builtin_endpoints::kPublicationsSecure, true},
    BuiltinTopicInfo{BuiltinTopic::subscriptions_secure, kSubscriptionsSecureWriter,
                     kSubscriptionsSecureReader, builtin_endpoints::kSubscriptionsSecure, true},
    BuiltinTopicInfo{BuiltinTopic::participants_secure, kParticipantsSecureWriter,
                     kParticipantsSecureReader, builtin_endpoints::kParticipantsSecure, true},
    BuiltinTopicInfo{BuiltinTopic::participant_message_secure, kParticipantMessageSecureWriter,
                     kParticipantMessageSecureReader, builtin_endpoints::kParticipantMessageSecure,
                     true},
};

/// Owns the stateful builtin writers and readers of one local participant.
class BuiltinEndpoints {
 public:
  using Deliver = std::function<bool(BuiltinTopic, Change&)>;
  BuiltinEndpoints(const GuidPrefix& prefix, MessageSender& sender, TimerQueue& timers,
                   Deliver deliver);

  /// Adds the secure endpoints.
  void add_secure_endpoints();

  StatefulWriter& writer(BuiltinTopic topic) { return *endpoints_[index(topic)].writer; }
  /// Both return nullptr if `id` is not one of the builtin endpoints.
  StatefulWriter* find_writer(const EntityId& id);
  StatefulReader* find_reader(const EntityId& id);
  /// Returns the one reader of the writer's topic; empty if there is none.
  std::span<StatefulReader* const> readers_of(const EntityId& writer) const;
  /// Calls `f(const BuiltinTopicInfo&, StatefulWriter&, StatefulReader&)` for each topic whose
  /// endpoints exist.
  template <class F>
  void each(F&& f) {
    for (const auto& info : kBuiltinTopics)
      if (auto& endpoint = endpoints_[index(info.topic)]; endpoint.writer)
        f(info, *endpoint.writer, *endpoint.reader);
  }
  template <class F>
  void each(F&& f) const {
    for (const auto& info : kBuiltinTopics)
      if (const auto& endpoint = endpoints_[index(info.topic)]; endpoint.writer)
        f(info, *endpoint.writer, *endpoint.reader);
  }

 private:
  struct Endpoint {
    std::unique_ptr<StatefulWriter> writer;
    std::unique_ptr<StatefulReader> reader;
  };
  static constexpr std::size_t index(BuiltinTopic topic) { return static_cast<std::size_t>(topic); }
  void add(const BuiltinTopicInfo& info);

  const GuidPrefix prefix_;
  MessageSender& sender_;
  TimerQueue& timers_;
  Deliver deliver_;
  std::array<Endpoint, kBuiltinTopics.size()> endpoints_;
  /// The readers of endpoints_, in the form that readers_of() returns.
  std::array<StatefulReader*, kBuiltinTopics.size()> readers_ = {};
};

}  // namespace ddssec::rtps
