// The log of the documents that a permissions CA signed: a text file with one JSON object per line.
// Lines are added to it, but never changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// Returns the SHA-256 of a document's text in hexadecimal, whatever its line ends are.
std::string document_digest(BytesView text);

/// The parsed log. A signature alone does not prove that the CA's owner signed a document, because
/// the key may have been stolen. The log is beside the CA's key, where only the owner can write.
class SigningLog {
 public:
  /// The status of a document in the log.
  enum class Standing : std::uint8_t {
    unknown,     ///< not signed by this CA according to the log
    superseded,  ///< signed, but another text replaced it in every file
    /// The last text that was signed for a file, by this CA or by one that followed, or one that
    /// this text extends.
    current,
  };

  /// Parses the log; an empty text is an empty log. The last line may lack its line end. Unreadable
  /// lines are ignored and listed in unreadable().
  static SigningLog parse(BytesView text);

  /// Returns the status of a document that was signed with the key of `ca`. `files` are the names
  /// of the file in which it is now. A later text for one of them supersedes it, even if it is the
  /// last text of another file, because a folder may have been moved and its former document put
  /// back.
  Standing standing(BytesView text, const Certificate& ca,
                    const std::vector<std::string>& files = {}) const;
  /// True if a text is the last one that was signed for this file, by any CA in the log. Only the
  /// log decides: the CA need not exist any more.
  bool is_last_of(const std::string& file, BytesView text) const;
  /// True if anything was signed for this file.
  bool has(const std::string& file) const { return last_in_.contains(file); }
  /// Returns the highest governance revision in the log, or 0 if there is none.
  std::uint32_t last_revision() const { return last_revision_; }
  /// Returns the numbers, from 1, of the lines that could not be read.
  const std::vector<int>& unreadable() const { return unreadable_; }

  /// Returns the line, with its end, for a document that `ca` signed for a file. `extended` is the
  /// former text if the document only says the same for a longer time. The former text stays
  /// current, because a command may be killed before the new one is in place.
  static std::string signed_line(BytesView text, const Certificate& ca, std::string_view file,
                                 WallTime now, BytesView extended = {});
  /// Returns the same lines with the revision of a governance document.
  static std::string with_revision(const std::string& lines, std::uint32_t revision);

 private:
  bool add_line(std::string_view line);
  bool is_current_in(const std::string& file, const std::string& document) const;
  bool is_superseded_in(const std::string& file, const std::string& document) const;

  std::unordered_set<std::string> signed_;  ///< "key_digest() of the CA, document_digest()"
  std::unordered_map<std::string, std::vector<std::string>> files_of_;  ///< by document_digest()
  std::unordered_map<std::string, std::string> last_in_;  ///< the last document_digest() of a file
  /// The number of the last line with a document_digest().
  std::unordered_map<std::string, std::size_t> line_of_;
  std::size_t lines_ = 0;
  /// The document_digest() of the former text, by that of the text that extends it.
  std::unordered_map<std::string, std::string> extends_;
  std::uint32_t last_revision_ = 0;
  std::vector<int> unreadable_;
};

}  // namespace ddssec::pki
