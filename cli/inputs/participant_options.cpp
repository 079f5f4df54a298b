#include "cli/inputs/participant_options.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "pki/ocsp_address.hpp"

namespace ddssec::cli {

Status check_name(std::string_view name, std::string_view any_other) {
  constexpr std::size_t kMax = 64;  // the limit of a common name, ub-common-name of X.520
  const auto is_letter_or_digit = [](char c) {
    return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9');
  };
  const auto is_fine = [&](char c) {
    return is_letter_or_digit(c) || c == '.' || c == '_' || c == '-';
  };
  if (!name.empty() && name.size() <= kMax && is_letter_or_digit(name[0]) &&
      std::ranges::all_of(name, is_fine))
    return {};
  ErrorDetails details{.found = '"' + std::string(name.substr(0, kMax)) + '"'};
  if (!any_other.empty()) {
    const auto hint = info(Code::name_unusable).hint;  // the hint's last clause is about --subject
    details.hint = fmt::format("{}; {}", hint.substr(0, hint.rfind("; ")), any_other);
  }
  return fail(Code::name_unusable, std::move(details));
}

Result<std::string> ocsp_responder(const Arguments& arguments) {
  constexpr std::size_t kMaxOctets = 512;
  auto url = arguments.text("--ocsp-responder");
  if (url.empty()) return url;
  const auto address = pki::parse_ocsp_address(url);
  if (address && url.size() <= kMaxOctets) return url;
  return fail(Code::usage,
              {.field = "--ocsp-responder",
               .expected = fmt::format("an http:// URL of at most {} octets", kMaxOctets),
               .found = url.substr(0, kMaxOctets),
               .note = address ? "" : address.error().details().note});
}

}  // namespace ddssec::cli
