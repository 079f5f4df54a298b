// The log of what a CA issued and revoked: a text file with one JSON object per line, to which
// lines are only ever added.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/key_digests.hpp"

namespace ddssec::pki {

/// The longest log that is read, in octets; about 300,000 certificates.
inline constexpr std::size_t kMaxIssueLogOctets = 64 * 1024 * 1024;
/// The longest line of a CA's log that is read, in octets; a longer one is never written.
inline constexpr std::size_t kMaxLogLineOctets = 64 * 1024;

/// The certificate in a participant's folder.
inline constexpr std::string_view kCertificateFile = "cert.pem";

/// One certificate that a CA issued.
struct IssuedCertificate {
  std::string serial;  ///< as Certificate::serial
  std::string subject;
  WallTime not_after = {};
  std::string folder = {};  ///< the folder where it was put; empty: unknown
  /// Its name there, unless cert.pem: several certificates may share a folder.
  std::string file = {};
  std::string sha256 = {};  ///< of the certificate, hexadecimal; empty in logs of other tools
  std::string key = {};     ///< key_digest(); empty in earlier logs
  std::optional<Revocation> revoked = std::nullopt;

  /// The folder, or the file in it that is not cert.pem; empty: not known.
  std::string place() const { return file.empty() ? folder : folder + "/" + file; }
  /// True if both were put into one folder under one name: they belong to one participant.
  bool shares_place_with(const IssuedCertificate& other) const {
    return !folder.empty() && folder == other.folder && file == other.file;
  }
};

/// The parsed log. Because lines are only added, it is safe against a crash: only the last line can
/// be cut short. Nothing that was written ever changes. It can be read with jq or an editor.
class IssueLog {
 public:
  /// Parses the log; an empty text is an empty log. The last line may lack its line end, because no
  /// part of a line is a whole JSON object. An unreadable line, such as one that is cut short, is
  /// ignored and listed in unreadable(): one damaged line must not stop the revocation of
  /// everything else.
  static IssueLog parse(BytesView text);

  /// In the order in which they were issued.
  const std::vector<IssuedCertificate>& issued() const { return issued_; }
  /// The lines that could not be read: issue_log_malformed, with the line.
  const std::vector<Error>& unreadable() const { return unreadable_; }
  /// The certificate of a serial number, or nullptr.
  const IssuedCertificate* find(std::string_view serial) const;
  /// All revocations, including those of certificates that are not in the log (issued before it).
  const std::vector<Revocation>& revocations() const { return revocations_; }
  bool is_revoked(std::string_view serial) const;
  /// The serial number of a revoked certificate of this key, which need not have been issued by the
  /// log; empty if there is none.
  std::string revoked_serial(const KeyDigests& key) const;
  /// The latest time before `limit` at which something was issued or revoked, by its lines.
  std::optional<WallTime> latest_before(WallTime limit) const;
  /// The places of all certificates that are not revoked, each once.
  std::vector<std::string> places() const;
  /// The places that no participant has left: those of the last certificate of each subject and
  /// key, and those of certificates whose key is not known.
  std::unordered_set<std::string> present_places() const;

  /// Adds one more revocation, like its line would. Error: issue_log_malformed.
  Status add(const Revocation& revocation);

  /// The line, with its end, for an issued certificate. `file`: its name in the folder. A second
  /// line for the same certificate tells only that it is in another place from then on.
  static std::string issued_line(const Certificate& certificate, std::string_view folder,
                                 WallTime now, std::string_view file = kCertificateFile);
  /// The line, with its end, for a revoked certificate. `key`: its key_digest(), if no line of the
  /// log contains it.
  static std::string revoked_line(const Revocation& revocation, std::string_view key = {});

 private:
  Status add_line(std::string_view line);
  void add_issued(IssuedCertificate one);

  std::vector<IssuedCertificate> issued_;
  std::vector<Revocation> revocations_;
  std::vector<Error> unreadable_;
  std::vector<WallTime> times_;
  std::unordered_map<std::string, std::size_t> issued_by_serial_;
  std::unordered_map<std::string, std::size_t> revoked_by_serial_;
  std::unordered_map<std::string, std::string> revoked_keys_;  ///< serial numbers, by digest
};

}  // namespace ddssec::pki
