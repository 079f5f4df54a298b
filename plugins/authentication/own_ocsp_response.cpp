#include "plugins/authentication/own_ocsp_response.hpp"

#include <filesystem>
#include <system_error>

#include "base/uri_source.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

namespace property = spi::property;

constexpr std::string_view kUsualResponse = "ocsp.der";

std::string beside_certificate(const spi::PropertyList& properties) {
  const auto uri = spi::property_value(properties, property::kIdentityCertificate);
  const auto file = file_named_by(absolute_uri(uri));
  if (!file) return {};
  const auto slash = file->rfind('/');
  return file->substr(0, slash == std::string::npos ? 0 : slash + 1) + std::string(kUsualResponse);
}

bool is_link(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_symlink(path, ignored);
}

}  // namespace

OwnOcspResponse::OwnOcspResponse(const std::string& path, std::chrono::seconds interval)
    : path_(path), watch_(path.empty() ? "" : "file:" + path, interval) {}

Result<OwnOcspResponse> OwnOcspResponse::of(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto interval, spi::files_poll_interval(properties));
  constexpr auto kName = property::kOcspResponse;
  const auto named = spi::property_value(properties, kName);
  if (named.empty()) return OwnOcspResponse(beside_certificate(properties), interval);
  const auto path = file_named_by(absolute_uri(named));
  if (!path)
    return fail(Code::invalid_property, {.document = std::string(kName),
                                         .expected = "file:PATH",
                                         .found = std::string(named.substr(0, 64))});
  return OwnOcspResponse(*path, interval);
}

Status OwnOcspResponse::read_first(const Judge& judge) {
  const auto read_now = read(judge);
  if (!read_now && read_now.error().code() == Code::ocsp_revoked)
    return std::unexpected(read_now.error());
  return {};
}

Result<bool> OwnOcspResponse::poll(std::chrono::nanoseconds monotonic, const Judge& judge) {
  const bool is_other_certificate = judged_for_ != judge.certificate;
  if (watch_.may_have_changed(monotonic) || is_other_certificate) {
    auto taken = read(judge);
    if (!taken || *taken) return taken;
  }
  if (revoked_) return std::unexpected(*revoked_);
  DDSSEC_RETURN_IF_ERROR(note_end(judge));
  return false;
}

// If the file disappears, the response that was read from it counts until its end. A missing file
// is no fault, because it may come later. A link was put there for a response, so a link to a
// missing file is a fault.
Result<bool> OwnOcspResponse::read(const Judge& judge) {
  judged_for_ = judge.certificate;
  if (path_.empty()) return false;
  auto file = load_uri(watch_.uri(), path_, pki::kMaxOcspOctets);
  if (!file && file.error().code() == Code::file_not_found && !is_link(path_)) return false;
  content_ = file ? sha256(*file) : Sha256Digest{};
  if (!file) return refuse(file.error());
  const auto good = judge.trust.ocsp(*file, judge.certificate, judge.now);
  revoked_.reset();
  if (!good && good.error().code() == Code::ocsp_revoked)
    revoked_ = good.error().with_default_document(path_);
  if (revoked_) return std::unexpected(*revoked_);
  if (!good) return refuse(good.error());
  // A recorded answer of the responder must not replace a later one.
  if (in_force_ && in_force_->certificate == judge.certificate &&
      good->this_update() < in_force_->good.this_update())
    return refuse(Error(Code::ocsp_expired,
                        {.field = "thisUpdate",
                         .expected = "not before " + to_string(in_force_->good.this_update()),
                         .found = to_string(good->this_update())}));
  refusals_.clear();
  if (in_force_ && in_force_->octets == *file && in_force_->certificate == judge.certificate)
    return false;
  in_force_ =
      std::make_shared<const OcspInForce>(OcspInForce{judge.certificate, *std::move(file), *good});
  has_reported_end_ = false;
  return true;
}

Result<bool> OwnOcspResponse::refuse(const Error& why) {
  watch_.force_change();
  if (!refusals_.note_refusal(why.code(), content_)) return false;
  return std::unexpected(refusals_.note(
      renewal_refused_error(Code::ocsp_response_refused, why, path_,
                            in_force_ ? "the response read before is sent until its end" : "")));
}

std::optional<DocumentState> OwnOcspResponse::state(const pki::Certificate& own) const {
  const bool is_ours = in_force_ && in_force_->certificate == own;
  if (!is_ours && !refusals_.refused()) return std::nullopt;
  DocumentState out{.kind = DocumentKind::ocsp_response,
                    .file = path_,
                    .refused = refusals_.refused(),
                    .state = refusals_.state()};
  if (is_ours)
    out.parts.push_back({.subject = own.subject(),
                         .number = own.serial(),
                         .until = in_force_->good.until(),
                         .sha256 = to_hex(sha256(in_force_->octets))});
  return out;
}

Status OwnOcspResponse::note_end(const Judge& judge) {
  if (!in_force_ || has_reported_end_ || in_force_->good.holds_at(judge.now)) return {};
  has_reported_end_ = true;
  return fail(Code::ocsp_response_ended, {.document = path_,
                                          .field = "nextUpdate",
                                          .expected = "a time after " + to_string(judge.now),
                                          .found = to_string(in_force_->good.until())});
}

}  // namespace ddssec::authentication
