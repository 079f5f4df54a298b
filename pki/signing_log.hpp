// What a permissions CA signed: a plain text of one JSON object a line, only ever added to.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// SHA-256 of a document's text, hexadecimal, whatever its line ends are.
std::string document_digest(BytesView text);

/// The log, read. A signature alone does not show that the CA's owner signed a document: the key
/// may have been stolen. The log lies beside the CA's key, where only its owner writes.
class SigningLog {
 public:
  /// What the log says of a document.
  enum class Standing : std::uint8_t {
    unknown,     ///< not signed by this CA, by this log
    superseded,  ///< signed, but another text took its place in every file
    current,     ///< the last text that was signed for a file, by this CA or by one that followed
  };

  /// Of an empty text, nothing was signed. A last line without line end is passed over: its
  /// command did not come to an end. Other lines that cannot be read count for nothing.
  static SigningLog parse(BytesView text);

  /// What the log says of a document that `ca`'s key signed.
  Standing standing(BytesView text, const Certificate& ca) const;
  /// True if a text is the last one that was signed for this file, by whichever of the CAs that the
  /// log had. The log alone vouches for it: its signature need not be of a CA that still exists.
  bool is_last_of(const std::string& file, BytesView text) const;
  /// The numbers, from 1, of the lines that could not be read.
  const std::vector<int>& unreadable() const { return unreadable_; }

  /// The line, with its end, that says that `ca` signed a document for a file.
  static std::string signed_line(BytesView text, const Certificate& ca, std::string_view file,
                                 WallTime now);

 private:
  bool add_line(std::string_view line);

  std::unordered_set<std::string> signed_;  ///< "key_digest() of the CA, document_digest()"
  std::unordered_map<std::string, std::vector<std::string>> files_of_;  ///< by document_digest()
  std::unordered_map<std::string, std::string> last_in_;  ///< by file: the last document_digest()
  std::vector<int> unreadable_;
};

}  // namespace ddssec::pki
