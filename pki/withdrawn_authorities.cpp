#include "pki/withdrawn_authorities.hpp"

#include <algorithm>

#include "base/bytes.hpp"

namespace ddssec::pki {
namespace {

constexpr std::size_t kMaxDescription = 512;
constexpr std::size_t kShownDigits = 16;

std::string describe(const Certificate& ca) {
  return ca.subject() + " (SHA-256 " + to_hex(ca.fingerprint()).substr(0, kShownDigits) + "...)";
}

}  // namespace

std::vector<Certificate> leaving(const std::vector<Certificate>& former,
                                 const std::vector<Certificate>& next) {
  std::vector<Certificate> out;
  std::ranges::copy_if(former, std::back_inserter(out), [&](const Certificate& ca) {
    return std::ranges::find(next, ca) == next.end();
  });
  return out;
}

Status WithdrawnAuthorities::check(const std::vector<Certificate>& former,
                                   const std::vector<Certificate>& next) const {
  for (const auto& ca : next)
    if (withdrawn_.contains(ca.fingerprint()))
      return fail(Code::ca_put_back, {.expected = "no CA that this participant ceased to trust",
                                      .found = describe(ca)});
  if (withdrawn_.size() + leaving(former, next).size() > kMaxWithdrawn)
    return fail(Code::ca_put_back, {.expected = "at most " + std::to_string(kMaxWithdrawn) +
                                                " CAs that leave while the participant runs"});
  return {};
}

void WithdrawnAuthorities::note(const std::vector<Certificate>& former,
                                const std::vector<Certificate>& next) {
  for (const auto& ca : leaving(former, next)) withdrawn_.insert(ca.fingerprint());
}

void WithdrawnAuthorities::forget(const std::vector<Certificate>& authorities) {
  for (const auto& ca : authorities) withdrawn_.erase(ca.fingerprint());
}

std::string describe(const std::vector<Certificate>& authorities) {
  std::string out;
  for (const auto& ca : authorities) out += (out.empty() ? "" : "; ") + describe(ca);
  return out.substr(0, kMaxDescription);
}

}  // namespace ddssec::pki
