// The lines that the agent's processes send to each other. A process with fewer rights may have
// sent anything, so each line is checked when it is read.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// The longest line, in octets. It has room for a signed permissions document in hexadecimal.
inline constexpr std::size_t kMaxAgentLine = 4 * 1024 * 1024;

/// A participant's request for a new certificate.
struct RenewalRequest {
  std::string request;               ///< PKCS#10, PEM
  std::string certificate;           ///< the one in place, PEM
  Bytes permissions = {};            ///< those in place, to be extended; empty: they stay
  std::chrono::seconds lifetime{1};  ///< of the certificate
  /// Only the permissions are due; the certificate is renewed with them if they can be extended.
  bool is_only_for_permissions = false;
};

/// The CA's answer to a RenewalRequest.
struct RenewalAnswer {
  std::string certificate;            ///< PEM
  Bytes permissions = {};             ///< signed; empty: those in place stay
  std::optional<Error> problem = {};  ///< why permissions or a list could not be renewed
  std::optional<Error> notice = {};   ///< a warning about the CA's files; not for the worker
  /// The CA's renewal list with this certificate. Empty if there is none or if it is too long for a
  /// line.
  std::string renewals = {};
};

/// A participant's request for a document: "permissions", "crl" or "renewals".
struct DocumentRequest {
  std::string wanted;
  std::string request;      ///< PKCS#10, PEM, for permissions: proves possession of the key
  std::string certificate;  ///< the one in place, PEM
};

/// Returns the value as one line, without a line break; json_from reads it.
std::string to_line(const Json& value);
/// Reads a line. Error: internal (it is no JSON object).
Result<Json> json_from(std::string_view line);

/// Writes one line into a pipe. Returns 0, or 1 if no process reads it.
int send_line(int out, const Json& value);
/// Returns the line that a process sends instead of a result.
Json error_line(const Error& error);
/// Adds the first notice of this process (frame/notices.hpp) as a member, if there is one and the
/// line has no such member. Drops all other notices.
void add_notice_to(Json& line, const std::string& member);

/// Writes the request as a line that request_from reads.
Json to_json(const RenewalRequest& request);
/// Reads a request. A text that is absent is empty. Error: internal (the permissions are not
/// hexadecimal).
Result<RenewalRequest> request_from(const Json& json);
/// Writes the answer, without its notice, as a line that answer_from reads.
Json to_json(const RenewalAnswer& answer);
/// Returns the answer as one line with its line break. If it is too long, removes the renewal list
/// from the answer.
std::string answer_line(RenewalAnswer& answer);
/// Reads an answer. A text that is absent is empty. Errors: internal (the permissions are not
/// hexadecimal), the error that the line reports.
Result<RenewalAnswer> answer_from(const Json& json);

/// Writes the request as a line that document_request_from reads.
Json to_json(const DocumentRequest& request);
/// Reads a request. A text that is absent is empty.
DocumentRequest document_request_from(const Json& json);
/// Writes a document as a line that document_from reads.
Json document_line(BytesView document);
/// Reads a document. Errors: internal (not hexadecimal), the error that the line reports.
Result<Bytes> document_from(const Json& json);

/// Writes an error with all of its details.
Json error_to_json(const Error& error);
/// Reads an error. An unknown code is read as `internal`.
Error reported_error(const Json& json);

/// Returns the text of a member. Empty if there is no member of that name or it is not a text.
std::string text_in(const Json& json, std::string_view name);
/// Returns the number of a member. 0 if there is no member of that name or it is not an integer.
std::int64_t number_in(const Json& json, std::string_view name);

}  // namespace ddssec::cli
