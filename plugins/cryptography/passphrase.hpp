// The passphrases of a domain's pre-shared keys (DDS-Security 1.2 10.5.1, table 71).
#pragma once

#include <array>
#include <chrono>
#include <vector>

#include "base/event.hpp"
#include "base/file_watch.hpp"
#include "base/secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

struct Passphrase {
  /// Octets, printable ASCII.
  using Text = Secret<struct PassphraseTag, 512>;
  std::uint32_t id = 0;
  Text text = {};
  /// In constant time for one length of the text.
  bool operator==(const Passphrase&) const = default;
};

/// Those that are only accepted, besides the one that is used to send.
inline constexpr std::size_t kMostExtraPassphrases = 15;

/// Where a participant's passphrases come from, so that they can be read again.
class PassphraseFiles {
 public:
  /// `poll_interval`: between two looks at the files; 0: never.
  PassphraseFiles(const spi::PropertyList& properties, std::chrono::nanoseconds poll_interval);

  /// The passphrase to send with, then those that are accepted as well. A file that others may read
  /// raises psk_passphrase_exposed. Errors: missing_property, those of base/source.hpp,
  /// invalid_property (not ID:PASSPHRASE; an id that is reserved; one id for two passphrases; too
  /// many); the document is the property, and none repeats any of a passphrase.
  Result<std::vector<Passphrase>> load(EventSink& events) const;

  /// See FileWatch.
  bool may_have_changed(std::chrono::nanoseconds now);
  void look_again();
  /// What the property says, to be told: where a passphrase is, not which.
  std::string place_of(std::string_view property) const;

 private:
  std::string own_, extra_;  ///< URIs
  std::array<FileWatch, 2> watches_;
};

}  // namespace ddssec::cryptography
