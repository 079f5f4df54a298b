// Asks running processes which documents they use (base/status_server.hpp).
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "base/file_descriptor.hpp"
#include "base/result.hpp"
#include "cli/frame/fields.hpp"

namespace ddssec::cli {

/// A certificate, list or document in a file.
struct ShownDocumentPart {
  static constexpr std::string_view kDef = "document part";
  std::string subject, number;
  std::optional<std::string> until;
  std::string sha256;

  static constexpr auto fields() {
    using Self = ShownDocumentPart;
    return std::tuple(field<&Self::subject>(), field<&Self::number>(),
                      field<&Self::until>({.note = "null: no end", .def = "time"}),
                      field<&Self::sha256>());
  }
};

/// The reason why a file was refused or a participant was cut off.
struct StatusRefusal {
  static constexpr std::string_view kDef = "refusal";
  std::string at, file;
  int code;
  std::string name, sentence;
  bool stands;
  std::optional<bool> waits;  ///< empty: ddssec 0.2 does not report it

  static constexpr auto fields() {
    using Self = StatusRefusal;
    return std::tuple(field<&Self::at>({.def = "time"}), field<&Self::file>(), field<&Self::code>(),
                      field<&Self::name>(), field<&Self::sentence>(),
                      field<&Self::stands>({"false: no longer"}),
                      field<&Self::waits>({"true: it is taken when it begins; null: not known"}));
  }
};

/// A document that a running participant uses, as its status socket reports it. The report is not
/// authenticated.
struct RunningDocument {
  std::string kind, file;
  std::optional<std::string> state;  ///< of the file; empty: ddssec 0.3 does not report it
  std::string since;
  std::vector<ShownDocumentPart> in_force;
  unsigned more;
  std::optional<ShownDocumentPart> waiting;  ///< empty: ddssec 0.2 does not report it
  std::optional<StatusRefusal> refused;

  static constexpr auto fields() {
    using Self = RunningDocument;
    return std::tuple(
        field<&Self::kind>(
            {.words = "identity certificate|identity CA|revocation list|renewal list|OCSP "
                      "response|permissions CA|permissions|listed permissions|governance"}),
        field<&Self::file>({.def = "path"}),
        field<&Self::state>(
            {.note = "of the file; null: not known", .words = "current|candidate|refused"}),
        field<&Self::since>({.def = "time"}), field<&Self::in_force>(),
        field<&Self::more>({"how many more"}),
        field<&Self::waiting>(
            {.note = "for peers, to come into force; null: nothing", .has_same_members = true}),
        field<&Self::refused>({"null: nothing"}));
  }
};

/// A participant of a running process, as its status socket reports it.
struct RunningParticipant {
  static constexpr std::string_view kDef = "running participant";
  std::int64_t identity;
  std::string guid, subject;
  std::optional<StatusRefusal> cut_off;
  std::vector<RunningDocument> documents;

  static constexpr auto fields() {
    using Self = RunningParticipant;
    return std::tuple(
        field<&Self::identity>({"its handle in the process"}), field<&Self::guid>(),
        field<&Self::subject>(),
        field<&Self::cut_off>({.note = "as `refused`; null: it is not", .has_same_members = true}),
        field<&Self::documents>());
  }
};

/// The sockets of a folder that DDSSEC_STATUS_DIR names.
class StatusFolder {
 public:
  struct Socket {
    pid_t pid;
    std::string name;
  };

  /// Opens the folder and lists its sockets. Errors: file_not_found, file_unreadable,
  /// status_of_another_user (it may not be entered), status_folder_untrusted, link_untrusted.
  static Result<StatusFolder> open(const std::filesystem::path& path);

  static constexpr std::size_t kMaxSockets = 1024;

  /// Returns the sockets ddssec-PID.sock and ddssec-PID-2.sock to -8.sock, in order; at most
  /// kMaxSockets.
  const std::vector<Socket>& sockets() const { return sockets_; }
  /// Returns the number of sockets that were left out.
  std::size_t left_out() const { return left_out_; }
  const std::filesystem::path& path() const { return path_; }

  struct Answer {
    std::vector<RunningParticipant> participants;
    std::uint64_t left_out = 0;  ///< number of participants that the answer had no room for
  };
  /// Asks for the participants of the process. Only an answer of the folder's owner, of this user
  /// or of root is accepted. The size of each answer is limited, and so are the size and the time
  /// of all answers of the folder together. Errors: status_process_ended, status_of_another_user,
  /// status_unanswered.
  Result<Answer> ask(const Socket& socket);

 private:
  StatusFolder(std::filesystem::path path, FileDescriptor folder, uid_t owner);
  void list();
  std::unexpected<Error> socket_error(const Socket& socket, Code code, std::string note) const;
  Result<FileDescriptor> connect(const Socket& socket) const;
  Status check_answering(const Socket& socket, int connection) const;
  Result<std::string> read_all(const Socket& socket, int connection);

  std::filesystem::path path_;
  FileDescriptor folder_;
  uid_t owner_;
  std::vector<Socket> sockets_;
  std::size_t left_out_ = 0;
  std::size_t octets_left_;
  std::chrono::steady_clock::time_point until_{};  ///< no answer counts later
};

/// True if a process has this number.
bool is_running(pid_t pid);

}  // namespace ddssec::cli
