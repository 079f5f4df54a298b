// The revocation lists of a local identity, and newer ones that come while it runs.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/file_watch.hpp"
#include "base/hash.hpp"
#include "base/renewal_refusals.hpp"
#include "pki/crl.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// Success if `lists` may replace `former`. Every list of an issuer among `anchors` must be signed
/// by the issuer and valid now, unless `former` has it, and no list of these issuers may be lost or
/// go back in time. Lists of other issuers have no effect and are skipped. Errors: those of
/// Crl::check, crl_missing, crl_older.
Status check_renewal(const std::vector<pki::Crl>& lists, const std::vector<pki::Crl>& former,
                     const std::vector<pki::Certificate>& anchors, WallTime now);

/// The revocation lists of a local identity and their files. Not thread-safe.
class RevocationLists {
 public:
  /// Loads the list that the properties name: one that must exist, or else one that may come later.
  /// If they name neither, it is crl.pem beside the identity certificate and beside the identity
  /// CA, which may also come later. These do not count if a trusted_ca_dir is configured, which
  /// cannot be combined with a list. Otherwise both count, from the start or as soon as they come:
  /// the newest list of each CA among `anchors` is in force. Errors name the property or the path:
  /// invalid_property, property_without_effect (both are named), those of load_uri and
  /// Crl::all_from, crl_file_empty.
  static Result<RevocationLists> load(const spi::PropertyList& properties,
                                      const std::vector<pki::Certificate>& anchors, WallTime now);

  const std::vector<pki::Crl>& in_force() const { return lists_; }
  /// Returns the list in force whose nextUpdate is `end`; nullptr if there is none.
  const pki::Crl* first_to_end(std::optional<WallTime> end) const;
  /// Returns the number and the date of each list, for a person.
  std::string description() const;
  /// Returns the paths of the lists' files, or of the file that may come; empty if there is
  /// neither.
  std::string path() const;
  /// Returns no_revocation_list for a participant without any list, with the places where a list is
  /// looked for. Empty if there is a list, or no folder to look in.
  std::optional<Error> absence() const;

  /// Judges lists that would replace those in force, and uses them if they are good.
  using Accept = std::function<Status(const std::vector<pki::Crl>&)>;
  /// Reads each file that may have changed. Returns true if other lists came into force, and false
  /// if the lists are the same as before. An error describes the fault of a file; the former lists
  /// stay in force. The error comes only if the file was wrong at two looks, so that a file that is
  /// just being written causes none, and once as long as the file stays the same. Errors: those of
  /// load_uri, Crl::all_from and `accept`, crl_file_empty; crl_copy_older for a file with an
  /// older list than the other file.
  Result<bool> poll(const Clock& clock, const std::vector<pki::Certificate>& anchors,
                    const Accept& accept);

  /// Returns the error of poll() about a file that has not been good since; empty if there is none.
  std::optional<Error> refused() const;

  /// Returns the state of the files.
  FileState state() const;

  /// Makes the next poll read every file, whatever the interval is.
  void force_poll() {
    for (auto& place : places_) place.watch.force_poll();
  }

  /// Reads the lists as they are in the files now, whether these have changed or not. It is for a
  /// caller that takes the lists together with CAs, which are `anchors`. Errors: those of
  /// load_uri and Crl::all_from, crl_file_empty.
  Result<RevocationLists> read(const std::vector<pki::Certificate>& anchors, WallTime now) const;

 private:
  /// A file that contains lists, or may contain them later.
  struct Place {
    Place(std::string_view from, std::chrono::seconds interval);

    FileWatch watch;
    std::string path;                  ///< empty if it is not a file
    std::vector<pki::Crl> lists = {};  ///< the lists last accepted from this place
    Sha256Digest content{};            ///< digest of the file with these lists
    RenewalRefusals refusals = {};
  };

  /// The data by which a place is judged.
  struct Question {
    const std::vector<pki::Certificate>& anchors;
    WallTime now;
    const Accept& accept;
  };

  enum class MissingFile : std::uint8_t { refused, may_come_later };
  static Status read_first(Place& place, std::string_view name, MissingFile missing);
  std::vector<pki::Crl> together(const std::vector<pki::Certificate>& anchors, WallTime now) const;
  Result<bool> poll_place(Place& place, const Question& question);
  Result<bool> adopt_lists(BytesView octets, Place& place, const Question& question);
  Status check_current(const Place& place, const Question& question) const;
  Result<bool> refuse(Place& place, const Error& error, const Sha256Digest& content);

  std::chrono::seconds interval_{0};
  std::vector<Place> places_;
  std::vector<pki::Crl> lists_;  ///< in force: the newest list of each CA from all places
};

}  // namespace ddssec::authentication
