// The log of the certificates that a CA issued and revoked: a text file with one JSON object per
// line. Lines are added to it, but never changed.
#pragma once

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

/// The longest log that is read, in octets. It has room for about 300,000 certificates.
inline constexpr std::size_t kMaxIssueLogOctets = 64 * 1024 * 1024;
/// The longest line of a CA's log that is read, in octets. A longer one is never written.
inline constexpr std::size_t kMaxLogLineOctets = 64 * 1024;

/// The name of the certificate's file in a participant's folder.
inline constexpr std::string_view kCertificateFile = "cert.pem";

/// One certificate that a CA issued.
struct IssuedCertificate {
  std::string serial;  ///< as Certificate::serial
  std::string subject;
  WallTime not_after = {};
  std::string folder = {};  ///< the folder where it was put; empty if unknown
  /// Its file name there if that is not cert.pem. Several certificates may share a folder.
  std::string file = {};
  std::string sha256 = {};  ///< digest of the certificate, hexadecimal; empty in other tools' logs
  std::string key = {};     ///< key_digest(), or empty in logs of earlier versions
  std::optional<Revocation> revoked = std::nullopt;

  /// Returns the folder, or the path of the file in it that is not cert.pem; empty if not known.
  std::string place() const { return file.empty() ? folder : folder + "/" + file; }
  /// True if both were put into one folder under one name, so that they belong to one participant.
  bool shares_place_with(const IssuedCertificate& other) const {
    return !folder.empty() && folder == other.folder && file == other.file;
  }
};

/// The parsed log. A crash can damage only the last line, because lines are only added and nothing
/// that was written ever changes. The log can be read with jq or an editor.
class IssueLog {
 public:
  /// Parses the log; an empty text is an empty log. The last line may lack its line end, because no
  /// part of a line is a whole JSON object. An unreadable line, such as one that was truncated, is
  /// ignored and listed in unreadable(): one damaged line must not prevent the revocation of all
  /// other certificates.
  static IssueLog parse(BytesView text);

  /// Returns the certificates in the order in which they were issued.
  const std::vector<IssuedCertificate>& issued() const { return issued_; }
  /// Returns an issue_log_malformed for each line that could not be read, with the line's number.
  const std::vector<Error>& unreadable() const { return unreadable_; }
  /// Returns the certificate of a serial number, or nullptr.
  const IssuedCertificate* find(std::string_view serial) const;
  /// Returns all revocations, including those of certificates that were issued before the log
  /// began.
  const std::vector<Revocation>& revocations() const { return revocations_; }
  bool is_revoked(std::string_view serial) const;
  /// Returns the serial number of a revoked certificate of this key, whose issue need not be in the
  /// log; empty if there is none.
  std::string revoked_serial(const KeyDigests& key) const;
  /// Returns the latest time before `limit` at which something was issued or revoked.
  std::optional<WallTime> latest_before(WallTime limit) const;
  /// Returns the places of all certificates that are not revoked, each once.
  std::vector<std::string> places() const;
  /// Returns the places at which every certificate is revoked, each once.
  std::vector<std::string> revoked_places() const;
  /// Returns the places that no participant has left: those of the last certificate of each subject
  /// and key, and those of certificates whose key is not known.
  std::unordered_set<std::string> present_places() const;

  /// Adds one more revocation, as its line would. Error: issue_log_malformed.
  Status add(const Revocation& revocation);

  /// Returns the line, with its end, for an issued certificate. `file` is its name in the folder. A
  /// second line for the same certificate only says that it is in another place from then on.
  static std::string issued_line(const Certificate& certificate, std::string_view folder,
                                 WallTime now, std::string_view file = kCertificateFile);
  /// Returns the line, with its end, for a revoked certificate. `key` is its key_digest(), to be
  /// given if no line of the log contains it.
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
