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
/// issuers have no effect and are passed over. Errors: those of Crl::check, crl_missing,
/// crl_older.
Status check_renewal(const std::vector<pki::Crl>& lists, const std::vector<pki::Crl>& former,
                     const std::vector<pki::Certificate>& anchors, WallTime now);

/// Not thread-safe.
class RevocationLists {
 public:
  /// What the properties name: a list that must be there, or else one that may come later. If they
  /// name neither, crl.pem beside the identity certificate or beside the identity CA, which may
  /// come later, too; not where a trusted_ca_dir is configured, which goes with no list. One that
  /// is there counts from the start. Errors name the property or the path: invalid_property,
  /// property_without_effect (both are named), those of ddssec::load and Crl::all_from,
  /// crl_file_empty.
  static Result<RevocationLists> load(const spi::PropertyList& properties);

  const std::vector<pki::Crl>& in_force() const { return lists_; }
  /// The list in force whose nextUpdate is `end`; null: there is none.
  const pki::Crl* first_to_end(std::optional<WallTime> end) const;
  /// Number and date of each, for a person.
  std::string description() const;
  /// The path of their file, or of the file that may come; empty if there is neither.
  std::string path() const;
  /// For a participant without any list: no_revocation_list, with where one is looked for. Nothing
  /// if there is a list, or no folder to look in.
  std::optional<Error> absence() const;

  /// Judges lists that would take the place of those in force, and uses them if they are good.
  using Accept = std::function<Status(const std::vector<pki::Crl>&)>;
  /// Reads the file if it may have changed. True: other lists are in force. False: the same as
  /// before. An error says what is wrong with the file; the former lists stay in force. It comes
  /// when the file was wrong at two looks, so not of one that is just being written, and once as
  /// long as the file stays the same. `now`: Clock::monotonic. Errors: those of ddssec::load,
  /// Crl::all_from and `accept`, crl_file_empty.
  Result<bool> look(std::chrono::nanoseconds now, const Accept& accept);

  /// What a file holds now.
  struct Present {
    std::vector<pki::Crl> lists;
    std::optional<std::size_t> place = {};  ///< empty: there is no file, `lists` are in force
    Sha256Digest content = {};
  };
  /// The lists as they are now, whether they have changed or not. For a caller that takes them
  /// together with CAs. Errors: those of ddssec::load and Crl::all_from, crl_file_empty.
  Result<Present> read() const;
  /// They are in force from now on.
  void take(Present present);

 private:
  struct Refusal {
    Code code;
    Sha256Digest content;
    bool operator==(const Refusal&) const = default;
  };

  /// A file that holds lists, or may later.
  struct Place {
    Place(std::string_view from, std::chrono::seconds interval);

    FileWatch watch;
    std::string path;          ///< empty if it is no file
    Sha256Digest content{};    ///< of what the lists in force are from
    bool was_refused = false;  ///< at the last look
    std::optional<Refusal> told = {};
  };

  Status read_first(Place& place, std::string_view name, bool may_come_later);
  void keep_only(Place& place);
  Result<bool> look_at(Place& place, const Accept& accept);
  Result<bool> judge(BytesView octets, const std::string& uri, const Accept& accept);
  Result<bool> refuse(Place& place, const Error& error, const Sha256Digest& content);

  std::chrono::seconds interval_{0};
  std::vector<Place> places_;  ///< one alone once a list is in force
  std::vector<pki::Crl> lists_;
};

}  // namespace ddssec::authentication
