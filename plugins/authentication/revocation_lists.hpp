// The revocation lists of a local identity, and newer ones that come while it runs.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/file_watch.hpp"
#include "base/hash.hpp"
#include "pki/crl.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// Success if `lists` may take the place of `former`: every list of an issuer among `anchors` is
/// signed by it and of this time, and none of theirs is lost or goes back in time. Lists of other
/// issuers count for nobody and are passed over. Errors: those of Crl::check, crl_missing,
/// crl_older.
Status check_renewal(const std::vector<pki::Crl>& lists, const std::vector<pki::Crl>& former,
                     const std::vector<pki::Certificate>& anchors, WallTime now);

/// Not thread-safe.
class RevocationLists {
 public:
  /// What the properties name: a list that must be there, or one that may come later, or none.
  /// Errors name the property: invalid_property, those of ddssec::load and Crl::all_from,
  /// crl_file_empty.
  static Result<RevocationLists> load(const spi::PropertyList& properties);

  const std::vector<pki::Crl>& in_force() const { return lists_; }
  /// Number and date of each, for a person.
  std::string description() const;
  /// The path of their file; empty if they come from no file.
  const std::string& path() const { return path_; }

  /// Judges lists that would take the place of those in force, and uses them if they are good.
  using Accept = std::function<Status(const std::vector<pki::Crl>&)>;
  /// Reads the file if it may have changed. True: other lists are in force. False: the same as
  /// before. An error says what is wrong with the file; the former lists stay in force. It comes
  /// when the file was wrong at two looks, so not of one that is just being written, and once as
  /// long as the file stays the same. `now`: Clock::monotonic. Errors: those of ddssec::load,
  /// Crl::all_from and `accept`, crl_file_empty.
  Result<bool> look(std::chrono::nanoseconds now, const Accept& accept);

 private:
  struct Refusal {
    Code code;
    Sha256Digest content;
    bool operator==(const Refusal&) const = default;
  };

  RevocationLists(std::string uri, std::chrono::seconds interval);
  Result<bool> take(BytesView octets, const Accept& accept);
  Result<bool> refuse(const Error& error, const Sha256Digest& content);

  std::string uri_;
  std::string path_;
  FileWatch watch_;
  Sha256Digest content_{};  ///< of what the lists are from
  std::vector<pki::Crl> lists_;
  bool was_refused_ = false;  ///< at the last look
  std::optional<Refusal> told_;
};

}  // namespace ddssec::authentication
