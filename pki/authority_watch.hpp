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
  AuthorityWatch(DocumentWatch::What what, std::chrono::seconds interval);

  using Authorities = std::vector<Certificate>;
  /// Judges CAs that would take the place of those in force, and uses them if they are good.
  using Take = std::function<Status(const Authorities&)>;
  /// Reads the file if it may have changed. True: other CAs are in force. A file with the same CAs
  /// in another order is the same. `in_force` must not change while `take` runs. Error as of
  /// DocumentWatch::look: the fault of the file, the refusal of `take`, or ca_put_back.
  Result<bool> look(std::chrono::nanoseconds now, const Authorities& in_force, const Take& take);

  /// The next look reads the file, whatever the interval is.
  void look_now() { file_.look_now(); }

  /// The last error of look(), while the file has not been good since.
  const std::optional<Error>& refused() const { return file_.refused(); }

  /// The path of the file, or the name of the property if it is none.
  const std::string& name() const { return file_.name(); }

 private:
  DocumentWatch file_;
  WithdrawnAuthorities withdrawn_;
};

}  // namespace ddssec::pki
