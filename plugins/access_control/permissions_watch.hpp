// The file of a local participant's permissions, which may be renewed while the participant runs.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "base/file_watch.hpp"
#include "plugins/spi/renewal_refusals.hpp"

namespace ddssec::access_control {

/// Not thread-safe.
class PermissionsWatch {
 public:
  /// Before the file is read for the first time. `name`: what an event calls the file.
  PermissionsWatch(std::string uri, std::string name, std::chrono::seconds interval);

  /// The octets that are in force were read.
  void note_read(BytesView file) { content_ = sha256(file); }

  /// Judges a document that would take the place of the one in force, and uses it if it is good.
  using Take = std::function<Status(BytesView)>;
  /// Reads the file, at most pki::kMostSentPermissionsOctets, if it may have changed. True: another
  /// document is in force. `now`: Clock::monotonic. Error, once as long as the file stays the same,
  /// and only if it was wrong at two looks in a row: permissions_renewal_refused, with what is
  /// wrong.
  Result<bool> look(std::chrono::nanoseconds now, const Take& take);

 private:
  std::string uri_;
  std::string name_;
  FileWatch watch_;
  Sha256Digest content_{};
  spi::RenewalRefusals refusals_;
};

}  // namespace ddssec::access_control
