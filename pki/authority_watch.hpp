// A CA file of a local participant, which may be replaced while the participant runs.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "base/document_watch.hpp"
#include "pki/withdrawn_authorities.hpp"

namespace ddssec::pki {

/// Not thread-safe.
class AuthorityWatch {
 public:
  /// Before the file is read for the first time. `what.max_octets` is set here.
  AuthorityWatch(DocumentWatch::WatchedDocument what, std::chrono::seconds interval);

  using Authorities = std::vector<Certificate>;
  /// Judges CAs that would take the place of those in force, and uses them if they are good.
  using Adopt = std::function<Status(const Authorities&)>;
  /// Reads the file if it may have changed. True: other CAs are in force. A file with the same CAs
  /// in another order is the same. `in_force` must not change while `adopt` runs. Error as of
  /// DocumentWatch::poll: the fault of the file, the refusal of `adopt`, or ca_put_back.
  Result<bool> poll(std::chrono::nanoseconds now, const Authorities& in_force, const Adopt& adopt);

  /// The next poll reads the file, whatever the interval is.
  void force_poll() { file_.force_poll(); }

  /// The last error of poll(), while the file has not been good since.
  const std::optional<Error>& refused() const { return file_.refused(); }

  /// The path of the file, or the name of the property if it is none.
  const std::string& name() const { return file_.name(); }

 private:
  DocumentWatch file_;
  WithdrawnAuthorities withdrawn_;
};

}  // namespace ddssec::pki
