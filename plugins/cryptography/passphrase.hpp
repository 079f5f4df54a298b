// The passphrases of a domain's pre-shared keys (DDS-Security 1.2 10.5.1, table 71).
#pragma once

#include <vector>

#include "base/event.hpp"
#include "base/secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

struct Passphrase {
  /// Octets, printable ASCII.
  using Text = Secret<struct PassphraseTag, 512>;
  std::uint32_t id = 0;
  Text text = {};
};

/// Those that are only accepted, besides the one that is used to send.
inline constexpr std::size_t kMostExtraPassphrases = 15;

/// The passphrase to send with, then those that are accepted as well. A file that others may read
/// raises psk_passphrase_exposed. Errors: missing_property, those of load(), invalid_property (not
/// ID:PASSPHRASE; an id that is reserved; one id for two passphrases; too many); none repeats any
/// of a passphrase.
Result<std::vector<Passphrase>> load_passphrases(const spi::PropertyList& properties,
                                                 EventSink& events);

}  // namespace ddssec::cryptography
