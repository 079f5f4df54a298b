// Which documents the participants of a process use, and what was refused in place of them: for a
// person who asks the running process (status_service.hpp).
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
#include "base/result.hpp"

namespace ddssec {

/// In the order in which they are shown.
enum class DocumentKind : std::uint8_t {
  identity_certificate,
  identity_ca,
  revocation_list,
  renewal_list,
  ocsp_response,
  permissions_ca,
  permissions,
  governance
};
/// "identity certificate", "revocation list".
std::string_view to_string(DocumentKind kind);

/// One certificate, list or text of a document. No part may hold anything secret.
struct DocumentPart {
  std::string subject = {};  ///< of a revocation list: its issuer; of a governance: its revision
  std::string number = {};   ///< serial number of a certificate, number of a revocation list
  std::optional<WallTime> until = {};
  std::string sha256 = {};  ///< of a certificate (DER) or of a document's file; hexadecimal
  bool operator==(const DocumentPart&) const = default;
};

/// What an engine knows about one document of a participant.
struct DocumentState {
  DocumentKind kind;
  std::string file = {};                     ///< its path, or the property that holds it
  std::vector<DocumentPart> parts = {};      ///< in force
  std::optional<Error> refused = {};         ///< why the file's present content is not in force
  std::optional<DocumentPart> waiting = {};  ///< comes into force when the peers are ready
  bool begins_later = false;                 ///< what was refused is taken when it begins
};

/// The record of all participants of a library. Engines note the state again and again; the record
/// finds what has changed. Its size is bounded by what engines bound: participants, and the
/// certificates of a file. Thread-safe; in the child of a fork() it notes nothing.
class DocumentsInUse {
 public:
  /// Parts that the answer has of one document; of more it has the number.
  static constexpr std::size_t kMaxParts = 16;
  /// Octets of the answer, about; participants that do not fit are counted.
  static constexpr std::size_t kMaxOctets = 512 * 1024;

  /// The participant with this identity handle. Empty texts leave what is known.
  void note_participant(std::int64_t identity, std::string guid, std::string subject);
  /// `now`: since then the state is in force or refused, if it is another than before. A refusal
  /// that no longer holds stays known as the last one.
  void note(std::int64_t identity, const std::vector<DocumentState>& states, WallTime now);
  /// The participant is cut off, for good: the first reason stays. Nothing for an identity that is
  /// not in the record.
  void note_end(std::int64_t identity, const Error& why, WallTime now);
  /// The participant no longer uses documents of these kinds.
  void forget(std::int64_t identity, std::span<const DocumentKind> kinds);

  /// One JSON object in ASCII, at most a little longer than kMaxOctets.
  std::string to_json() const;

 private:
  struct Refusal {
    Error why;
    WallTime at;
    bool stands;         ///< the file is still as it was refused
    bool waits = false;  ///< and is taken when it begins
  };
  struct Document {
    std::string file = {};
    std::vector<DocumentPart> parts = {};
    WallTime since = {};
    std::optional<Refusal> refusal = {};
    std::optional<DocumentPart> waiting = {};
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
