// The record of the documents that the participants of a process use, and of the documents that
// were refused. A person can read it from the running process (status_service.hpp).
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "base/clock.hpp"
#include "base/renewal_refusals.hpp"
#include "base/result.hpp"

namespace ddssec {

/// The kinds of documents, in the order in which they are shown.
enum class DocumentKind : std::uint8_t {
  identity_certificate,
  identity_ca,
  revocation_list,
  renewal_list,
  ocsp_response,
  permissions_ca,
  permissions,
  listed_permissions,  ///< permissions of peers on the renewal list
  governance
};
/// Returns "identity certificate", "revocation list" and so on.
std::string_view to_string(DocumentKind kind);

/// One certificate, list or text of a document. No part may hold anything secret.
struct DocumentPart {
  std::string subject = {};  ///< a revocation list has its issuer, a governance its revision
  std::string number = {};   ///< serial number of a certificate or number of a revocation list
  std::optional<WallTime> until = {};
  std::string sha256 = {};  ///< hash of a certificate (DER) or of the file, in hexadecimal
  bool operator==(const DocumentPart&) const = default;
};

/// The state of one document of a participant, as a plugin reports it.
struct DocumentState {
  DocumentKind kind;
  std::string file = {};                     ///< its path, or the property that holds it
  std::vector<DocumentPart> parts = {};      ///< the parts in force
  std::optional<Error> refused = {};         ///< why the file's present content is not in force
  std::optional<DocumentPart> waiting = {};  ///< it comes into force when the peers are ready
  /// The state of the file. A candidate with `refused` is adopted when its validity begins.
  FileState state = FileState::current;
};

/// The record of all participants of a library. Plugins note the state again and again; the record
/// finds what has changed. Its size is bounded because plugins bound the participants and the
/// certificates of a file. Thread-safe. In the child of a fork() it notes nothing.
class DocumentsInUse {
 public:
  /// The largest number of parts that the answer lists for one document. It counts the others.
  static constexpr std::size_t kMaxParts = 16;
  /// The approximate size of the answer in octets. Participants that do not fit are only counted.
  static constexpr std::size_t kMaxOctets = 512 * 1024;

  /// Notes the participant with this identity handle. An empty text leaves what is known.
  void note_participant(std::int64_t identity, std::string guid, std::string subject);
  /// Notes the state of documents. If a state differs from the last one, it counts as in force or
  /// refused since `now`. A refusal that no longer holds is kept as the last one. Does nothing for
  /// an identity that is not in the record.
  void note(std::int64_t identity, const std::vector<DocumentState>& states, WallTime now);
  /// Notes that the participant is permanently cut off. Only the first reason is kept. Does nothing
  /// for an identity that is not in the record.
  void note_end(std::int64_t identity, const Error& why, WallTime now);
  /// Notes that the participant no longer uses documents of these kinds. With its last document the
  /// participant leaves the record.
  void forget(std::int64_t identity, std::span<const DocumentKind> kinds);

  /// Returns one JSON object in ASCII, at most a little longer than kMaxOctets.
  std::string to_json() const;

 private:
  struct Refusal {
    Error why;
    WallTime at;
    bool stands;         ///< the file still has the content that was refused
    bool waits = false;  ///< that content is adopted when its validity begins
  };
  struct Document {
    std::string file = {};
    std::vector<DocumentPart> parts = {};
    WallTime since = {};
    std::optional<Refusal> refusal = {};
    std::optional<DocumentPart> waiting = {};
    FileState state = FileState::current;
  };
  struct Participant {
    std::string guid = {};
    std::string subject = {};
    std::map<DocumentKind, Document> documents = {};
    std::optional<Refusal> end = {};
  };

  static void note(Document& document, const DocumentState& state, WallTime now);
  static nlohmann::ordered_json json_of(const std::optional<Refusal>& refusal);
  static std::string json_of(std::int64_t identity, const Participant& participant);

  bool is_of_this_process() const;

  const pid_t pid_ = ::getpid();
  mutable std::mutex mutex_;
  std::map<std::int64_t, Participant> participants_;
};

}  // namespace ddssec
