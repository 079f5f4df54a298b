// What the class of a message with key tokens says of them.
#pragma once

#include "rtps/security/endpoint_keys.hpp"
#include "rtps/security/generic_message.hpp"

namespace ddssec::rtps {

/// True for keys of a remote writer, which local readers need.
inline bool is_for_readers(const GenericMessage& message) {
  return message.message_class == message_class::kDatawriterTokens ||
         message.message_class == message_class::kDatawriterTokensOfOne;
}

/// True for keys of a remote reader, which local writers need.
inline bool is_for_writers(const GenericMessage& message) {
  return message.message_class == message_class::kDatareaderTokens ||
         message.message_class == message_class::kDatareaderTokensOfOne;
}

/// Returns a message that requests the keys of a remote endpoint for a local one.
inline GenericMessage tokens_wanted(const Guid& local, const Guid& remote) {
  GenericMessage message;
  message.destination_endpoint = remote;
  message.source_endpoint = local;
  message.message_class = message_class::kTokensWanted;
  return message;
}

/// Returns the protection that the keys are for; 0 if the message names none.
inline ProtectionId protection_in(const GenericMessage& message) {
  const bool names_one = message.message_class == message_class::kDatawriterTokensOfOne ||
                         message.message_class == message_class::kDatareaderTokensOfOne ||
                         message.message_class == message_class::kParticipantTokensOfOne;
  return names_one ? static_cast<ProtectionId>(message.related.sequence_number) : 0;
}

}  // namespace ddssec::rtps
