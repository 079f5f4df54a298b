// The classes of ParticipantGenericMessage that DDS-Security defines.
#pragma once

#include <string_view>

/// The values of GenericMessageClassId.
namespace ddssec::spi::message_class {

inline constexpr std::string_view kAuthRequest = "dds.sec.auth_request";
inline constexpr std::string_view kAuthentication = "dds.sec.auth";
inline constexpr std::string_view kParticipantTokens = "dds.sec.participant_crypto_tokens";
inline constexpr std::string_view kDatawriterTokens = "dds.sec.datawriter_crypto_tokens";
inline constexpr std::string_view kDatareaderTokens = "dds.sec.datareader_crypto_tokens";

}  // namespace ddssec::spi::message_class
