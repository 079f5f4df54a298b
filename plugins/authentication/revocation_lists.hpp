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
  /// name neither, crl.pem beside the identity certificate and beside the identity CA, which may
  /// come later, too; not where a trusted_ca_dir is configured, which goes with no list. Both
  /// count, from the start or as soon as they come: of each CA among `anchors` the newest list is
  /// in force. Errors name the property or the path: invalid_property, property_without_effect
  /// (both are named), those of ddssec::load and Crl::all_from, crl_file_empty.
  static Result<RevocationLists> load(const spi::PropertyList& properties,
                                      const std::vector<pki::Certificate>& anchors, WallTime now);

  const std::vector<pki::Crl>& in_force() const { return lists_; }
  /// The list in force whose nextUpdate is `end`; null: there is none.
  const pki::Crl* first_to_end(std::optional<WallTime> end) const;
  /// Number and date of each, for a person.
  std::string description() const;
  /// The paths of their files, or of the file that may come; empty if there is neither.
  std::string path() const;
  /// For a participant without any list: no_revocation_list, with where one is looked for. Nothing
  /// if there is a list, or no folder to look in.
  std::optional<Error> absence() const;

  /// Judges lists that would take the place of those in force, and uses them if they are good.
  using Accept = std::function<Status(const std::vector<pki::Crl>&)>;
  /// Reads each file that may have changed. True: other lists are in force. False: the same as
  /// before. An error says what is wrong with a file; the former lists stay in force. It comes
  /// when the file was wrong at two looks, so not of one that is just being written, and once as
  /// long as the file stays the same. Errors: those of ddssec::load, Crl::all_from and `accept`,
  /// crl_file_empty; crl_copy_older for a file with an older list than the other file.
  Result<bool> poll(const Clock& clock, const std::vector<pki::Certificate>& anchors,
                    const Accept& accept);

  /// An error of look() about a file that has not been good since; nothing if there is none.
  std::optional<Error> refused() const;

  /// True if each file that was refused was refused only because its list begins in the future: it
  /// is taken when it begins.
  bool begins_later() const;

  /// The next look reads every file, whatever the interval is.
  void force_poll() {
    for (auto& place : places_) place.watch.force_poll();
  }

  /// The lists as they are in the files now, whether they have changed or not. For a caller that
  /// takes them together with CAs: these are `anchors`. Errors: those of ddssec::load and
  /// Crl::all_from, crl_file_empty.
  Result<RevocationLists> read(const std::vector<pki::Certificate>& anchors, WallTime now) const;

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
    std::string path;                  ///< empty if it is no file
    std::vector<pki::Crl> lists = {};  ///< as they were last accepted from this place
    Sha256Digest content{};            ///< of the file that they are from
    bool was_refused = false;          ///< at the last look
    std::optional<Refusal> told = {};
    std::optional<Error> refused = {};  ///< the last report, while the file was not good since
  };

  /// What a place is judged by.
  struct Question {
    const std::vector<pki::Certificate>& anchors;
    WallTime now;
    const Accept& accept;
  };

  static Status read_first(Place& place, std::string_view name, bool may_come_later);
  std::vector<pki::Crl> together(const std::vector<pki::Certificate>& anchors, WallTime now) const;
  Result<bool> look_at(Place& place, const Question& question);
  Result<bool> judge(BytesView octets, Place& place, const Question& question);
  Status check_current(const Place& place, const Question& question) const;
  Result<bool> refuse(Place& place, const Error& error, const Sha256Digest& content);

  std::chrono::seconds interval_{0};
  std::vector<Place> places_;
  std::vector<pki::Crl> lists_;  ///< in force: of each CA the newest of all places
};

}  // namespace ddssec::authentication
