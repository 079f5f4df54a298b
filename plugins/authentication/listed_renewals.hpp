// The certificates on a participant's renewal list: renewed ones of peers, and our own.
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

/// The renewal list of a local identity. Thread-safe.
class ListedRenewals {
 public:
  /// Makes the object from the properties. Errors: invalid_property (the place, the poll interval).
  static Result<std::shared_ptr<ListedRenewals>> of(const spi::PropertyList& properties);
  ListedRenewals(const std::vector<std::string>& uris, std::chrono::seconds interval)
      : watch_(uris, interval, Code::renewal_list_refused) {}

  /// The largest number of certificates that one poll verifies, so that a long list does not stop
  /// the host. Those that were verified in the former list are not verified again.
  static constexpr std::size_t kMaxVerifiedInAPoll = 16;

  /// Reads the list if it has changed, and verifies some of its entries. If all entries of another
  /// list are verified, returns the event renewal_list_taken. Entries that `trust` does not accept
  /// do not count. Errors: those of RenewalListWatch::poll; renewal_list_refused also if there are
  /// certificates and none of them counts.
  Result<std::optional<Error>> poll(const Clock& clock, const TrustStore& trust);
  /// Makes the next poll read the file, whatever the interval is.
  void force_poll();
  /// Also judges all entries again, because other CAs are trusted.
  void reevaluate();

  /// A session: the certificate of its handshake, and the one with which it ends.
  struct Session {
    const pki::Certificate& proven;
    const pki::Certificate& latest;
  };
  struct FoundCertificate {
    std::optional<pki::ValidChain> chain = {};
    std::string why_not = {};  ///< a reason for a person; empty if nothing is listed
  };
  /// Returns the certificate with which the session goes on. It has the same subject and the key
  /// that the handshake has proven, does not begin before the latest certificate, and `trust`
  /// accepts it at `now`. None if the proven one was revoked. It verifies the certificate, so that
  /// an entry also counts if no poll has verified it yet.
  FoundCertificate after(const Session& session, const TrustStore& trust, WallTime now) const;

  /// Returns the list in force, and what was refused; empty if there is neither.
  std::optional<DocumentState> state() const;

 private:
  struct JudgedList {
    std::vector<pki::Certificate> usable = {};
    std::vector<pki::Certificate> waiting = {};  ///< no poll has verified these yet
    /// The usable ones of the former list, as long as some of this list wait.
    std::vector<pki::Certificate> former = {};
    std::size_t permissions = 0;            ///< the number of permissions on the list
    std::size_t foreign = 0;                ///< certificates that do not count
    std::optional<Error> first_fault = {};  ///< of the first foreign one
  };
  static void verify_some(JudgedList& list, const TrustStore& trust, WallTime now);
  static Status check_counts(const JudgedList& list, const TrustStore& trust);
  Status adopt(const pki::RenewalList& list, const TrustStore& trust, WallTime now);
  Result<std::optional<Error>> note_verified(const TrustStore& trust);
  Error taken_event() const;
  std::string refusal_of(const pki::Certificate& listed, const Session& session) const;

  mutable std::mutex mutex_;
  pki::RenewalListWatch watch_;
  JudgedList list_;
  bool verdicts_hold_ = true;  ///< false after the trusted CAs or the revocation lists changed
  bool is_reported_ = true;    ///< false until the event about this list has been returned
  std::optional<Error> refused_when_verified_;
};

}  // namespace ddssec::authentication
