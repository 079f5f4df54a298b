// A file with a document of a local participant, which may be replaced while the participant runs.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/file_watch.hpp"
#include "base/renewal_refusals.hpp"

namespace ddssec {

/// Watches one file with a document, and adopts a document that replaces it. Not thread-safe.
class DocumentWatch {
 public:
  /// The watched document, and the contents of an event about it.
  struct WatchedDocument {
    std::string uri;
    std::string name;        ///< the property's name, for a document inside the property
    std::size_t max_octets;  ///< the largest size that is read
    Code refused;            ///< the event's code
    std::string_view stays;  ///< what stays in force after a refusal, for the event
    /// The event gives the remedy of its reason, because the document itself must be written again.
    bool gives_remedy_of_reason = false;
  };

  /// Create the watch before the file is read for the first time.
  DocumentWatch(WatchedDocument what, std::chrono::seconds interval);

  /// Notes the octets that are in force, so that poll() adopts the file only if its content
  /// differs.
  void note_read(BytesView file) { content_ = sha256(file); }

  /// Judges a document that would replace the one in force, and uses it if it is good.
  using Adopt = std::function<Status(BytesView)>;
  /// Reads the file if it may have changed. Returns true if another document is in force. `now` is
  /// Clock::monotonic. Error: WatchedDocument::refused, with what is wrong. It is returned only if
  /// the file was wrong at two polls in a row, and only once as long as the file stays the same.
  Result<bool> poll(std::chrono::nanoseconds now, const Adopt& adopt);

  /// While `adopt` runs: true if the poll before has read the same octets. A file that is being
  /// written grows, so it is not whole at least as long as this is false.
  bool is_as_at_last_poll() const { return is_as_at_last_poll_; }
  /// While `adopt` runs: leaves the decision to the next poll, which reads the file again. This is
  /// neither an adoption nor a refusal. `adopt` then succeeds without using the document.
  void decide_at_next_poll() { is_undecided_ = true; }
  /// Returns the device and inode of the file at the last poll; empty if there was no file.
  std::optional<FileWatch::FileId> file_id() const { return watch_.file_id(); }

  /// Makes the next poll read the file without waiting for the interval.
  void force_poll() { watch_.force_poll(); }

  /// Returns the file as it is now, whether it has changed or not. A caller that adopts it together
  /// with another file then calls note_read. Errors: those of load_uri.
  Result<Bytes> read() const;

  /// Returns the last error of poll(), or nothing if the file has been good since.
  const std::optional<Error>& refused() const { return refusals_.refused(); }
  /// Returns the state of the file.
  FileState state() const { return refusals_.state(); }

  /// Returns the absolute path of the file, or WatchedDocument::name if the document is not in a
  /// file.
  const std::string& name() const { return what_.name; }

 private:
  WatchedDocument what_;
  FileWatch watch_;
  Sha256Digest content_{};
  RenewalRefusals refusals_;
  std::optional<Sha256Digest> last_read_;  ///< digest of what the last poll read
  bool is_as_at_last_poll_ = false;
  bool is_undecided_ = false;
};

}  // namespace ddssec
