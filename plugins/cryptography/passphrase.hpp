// The passphrases of a domain's pre-shared keys (DDS-Security 1.2, clause 10.5.1, table 71).
#pragma once

#include <chrono>
#include <vector>

#include "base/event.hpp"
#include "base/file_watch.hpp"
#include "base/secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

/// A passphrase of pre-shared keys, and the id by which messages name it.
struct Passphrase {
  /// The passphrase: printable ASCII.
  using Text = Secret<struct PassphraseTag, 512>;
  std::uint32_t id = 0;
  Text text = {};
  /// The comparison takes constant time for a given length of the text.
  bool operator==(const Passphrase&) const = default;
};

/// The largest number of passphrases that are accepted only, besides the one to send with.
inline constexpr std::size_t kMaxExtraPassphrases = 15;

/// The sources of a participant's passphrases, so that they can be read again.
class PassphraseFiles {
 public:
  /// `poll_interval` is the time between two checks of the files; 0 means never.
  PassphraseFiles(const spi::PropertyList& properties, std::chrono::nanoseconds poll_interval);

  /// Reads the passphrase to send with, then those that are accepted as well. Raises
  /// psk_passphrase_exposed for a file that others may read. Errors: missing_property, those of
  /// base/uri_source.hpp, invalid_property (not ID:PASSPHRASE, a reserved id, one id for two
  /// passphrases, too many). The document of an error is the property; no error repeats any of a
  /// passphrase.
  Result<std::vector<Passphrase>> load(EventSink& events) const;

  /// True if a file of a passphrase may have changed since the last call (FileWatch).
  bool may_have_changed(std::chrono::nanoseconds now);
  void force_change();
  /// Returns the place named by the property, for messages: it shows where a passphrase is, but not
  /// the passphrase.
  std::string place_of(std::string_view property) const;

 private:
  FileWatch own_, extra_;
  bool has_extra_;
};

}  // namespace ddssec::cryptography
