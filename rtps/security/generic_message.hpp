// ParticipantGenericMessage: the messages of the stateless and of the volatile secure endpoints
// (DDS-Security 1.2, clause 7.3.22).
#pragma once

#include <string_view>
#include <vector>

#include "base/ids.hpp"
#include "plugins/spi/message_class.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::rtps {

/// Numbers a participant's generic messages. A repeated message keeps its number.
struct MessageIdentity {
  Guid source;
  std::int64_t sequence_number = 0;
  bool operator==(const MessageIdentity&) const = default;
};

/// GenericMessageClassId.
namespace message_class {
using namespace spi::message_class;
/// Specific to ddssec: a message without content, which the peer only has to acknowledge.
inline constexpr std::string_view kAreYouThere = "org.ddssec.are_you_there";
/// Specific to ddssec: a message without content. The participant leaves (leaving.hpp).
inline constexpr std::string_view kLeaving = "org.ddssec.leaving";
/// Specific to ddssec: documents that were renewed (DocumentRenewal), and the answer.
inline constexpr std::string_view kRenewal = "org.ddssec.renewed_documents";
inline constexpr std::string_view kRenewalAccepted = "org.ddssec.renewed_documents_taken";
/// Specific to ddssec: which governance document a participant has (GovernanceTransition).
inline constexpr std::string_view kGovernance = "org.ddssec.governance";
/// Specific to ddssec: an offer of shared memory, or the answer (memory_messages.hpp).
inline constexpr std::string_view kMemory = "org.ddssec.memory";
/// Specific to ddssec: an endpoint needs the tokens of another one once more.
inline constexpr std::string_view kTokensWanted = "org.ddssec.crypto_tokens_wanted";
/// Specific to ddssec: the tokens of an endpoint that may have two protections. The number of the
/// related message is the ProtectionId of the one that has these keys.
inline constexpr std::string_view kDatawriterTokensOfOne =
    "org.ddssec.datawriter_crypto_tokens_of_protection";
inline constexpr std::string_view kDatareaderTokensOfOne =
    "org.ddssec.datareader_crypto_tokens_of_protection";
/// Specific to ddssec: the tokens of a participant for whole messages, for one of two protections.
/// The number of the related message is the ProtectionId of that protection.
inline constexpr std::string_view kParticipantTokensOfOne =
    "org.ddssec.participant_crypto_tokens_of_protection";
}  // namespace message_class

/// ParticipantGenericMessage (DDS-Security 1.2, clause 7.5.2.4).
struct GenericMessage {
  MessageIdentity identity = {};
  MessageIdentity related = {};
  Guid destination_participant = {};
  Guid destination_endpoint = {};
  Guid source_endpoint = {};
  std::string message_class = {};
  std::vector<spi::Token> data = {};
  bool operator==(const GenericMessage&) const = default;
};

/// Returns the message with its encapsulation: plain XCDR1, little-endian, as Cyclone DDS and Fast
/// DDS write it.
Bytes write_generic_message(const GenericMessage& message);

/// Reads a message. Padding after the last token is allowed. Errors: truncated, malformed,
/// length_out_of_range (more than spi::kMaxTokensPerMessage), rtps_encapsulation_unsupported.
Result<GenericMessage> read_generic_message(BytesView payload);

}  // namespace ddssec::rtps
