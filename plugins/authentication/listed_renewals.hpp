// The certificates of a participant's renewal list: of peers that have renewed theirs, and our own.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/documents_in_use.hpp"
#include "pki/renewal_list_watch.hpp"
#include "plugins/authentication/trust_store.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// Thread-safe.
class ListedRenewals {
 public:
  /// Errors: invalid_property (the place, the poll interval).
  static Result<std::shared_ptr<ListedRenewals>> of(const spi::PropertyList& properties);
  ListedRenewals(const std::vector<std::string>& uris, std::chrono::seconds interval)
      : watch_(uris, interval, Code::renewal_list_refused) {}

  /// Reads the list, if it has changed. The event if another one is in force: renewal_list_taken.
  /// An entry that `trust` does not believe does not count. Error as RenewalListWatch::poll, also
  /// if there are certificates and none of them counts: renewal_list_refused.
  Result<std::optional<Error>> poll(const Clock& clock, const TrustStore& trust);
  /// The next poll reads the file, whatever the interval is.
  void force_poll();
  /// The same, and judges all entries again: other CAs are trusted.
  void judge_again();

  /// A session, by the certificate of its handshake and the one that it ends with.
  struct Session {
    const pki::Certificate& proven;
    const pki::Certificate& latest;
  };
  struct Found {
    std::optional<pki::ChainValid> chain = {};
    std::string why_not = {};  ///< for a person; empty: nothing is listed
  };
  /// The certificate with which the session goes on: of the same subject and the same key, which
  /// the handshake has proven, that begins not before the latest, and that `trust` believes at
  /// `now`. None if the proven one was revoked.
  Found after(const Session& session, const TrustStore& trust, WallTime now) const;
  /// True if this certificate is on the list.
  bool holds(const pki::Certificate& certificate) const;

  /// The list in force, and what was refused; empty if there is neither.
  std::optional<DocumentState> state() const;

 private:
  Status adopt(const pki::RenewalList& list, const TrustStore& trust, WallTime now);
  std::string refusal_of(const pki::Certificate& listed, const Session& session) const;

  mutable std::mutex mutex_;
  pki::RenewalListWatch watch_;
  std::vector<pki::Certificate> certificates_;
  std::size_t permissions_ = 0;  ///< how many the list has
  std::size_t foreign_ = 0;      ///< certificates that do not count
};

}  // namespace ddssec::authentication
