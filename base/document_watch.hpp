// A file with a document of a local participant, which may be replaced while the participant runs.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "base/file_watch.hpp"
#include "base/renewal_refusals.hpp"

namespace ddssec {

/// Watches one file with a document, and adopts what takes its place. Not thread-safe.
class DocumentWatch {
 public:
  /// What is watched, and what an event about it says.
  struct WatchedDocument {
    std::string uri;
    std::string name;        ///< of the property, for a document that stands there
    std::size_t max_octets;  ///< octets that are read
    Code refused;            ///< the event's code
    std::string_view stays;  ///< what is still in force then
    /// The event gives the remedy of its reason, because the document itself must be written anew.
    bool gives_remedy_of_reason = false;
  };

  /// Before the file is read for the first time.
  DocumentWatch(WatchedDocument what, std::chrono::seconds interval);

  /// The octets that are in force were read.
  void note_read(BytesView file) { content_ = sha256(file); }

  /// Judges a document that would take the place of the one in force, and uses it if it is good.
  using Adopt = std::function<Status(BytesView)>;
  /// Reads the file if it may have changed. True: another document is in force. `now`:
  /// Clock::monotonic. Error, once as long as the file stays the same, and only if it was wrong at
  /// two polls in a row: WatchedDocument::refused, with what is wrong.
  Result<bool> poll(std::chrono::nanoseconds now, const Adopt& adopt);

  /// The next poll reads the file, whatever the interval is.
  void force_poll() { watch_.force_poll(); }

  /// The file as it is now, whether it has changed or not. For a caller that takes it together with
  /// another one, and then calls note_read. Errors: those of ddssec::load.
  Result<Bytes> read() const;

  /// The last error of poll(), while the file has not been good since.
  const std::optional<Error>& refused() const { return refusals_.refused(); }
  /// See RenewalRefusals.
  bool begins_later() const { return refusals_.begins_later(); }

  /// The absolute path of the file, or WatchedDocument::name if it is none.
  const std::string& name() const { return what_.name; }

 private:
  WatchedDocument what_;
  FileWatch watch_;
  Sha256Digest content_{};
  RenewalRefusals refusals_;
};

}  // namespace ddssec
