#include "pki/authority_watch.hpp"

#include <algorithm>

#include "pki/certificate_source.hpp"

namespace ddssec::pki {
namespace {

bool have_the_same(const AuthorityWatch::Authorities& a, const AuthorityWatch::Authorities& b) {
  const auto is_in = [](const AuthorityWatch::Authorities& all) {
    return [&](const Certificate& ca) { return std::ranges::find(all, ca) != all.end(); };
  };
  return std::ranges::all_of(a, is_in(b)) && std::ranges::all_of(b, is_in(a));
}

DocumentWatch::WatchedDocument of_bundle(DocumentWatch::WatchedDocument what) {
  what.max_octets = kMaxBundleOctets;
  return what;
}

}  // namespace

AuthorityWatch::AuthorityWatch(DocumentWatch::WatchedDocument what, std::chrono::seconds interval)
    : file_(of_bundle(std::move(what)), interval) {}

Result<bool> AuthorityWatch::poll(std::chrono::nanoseconds now, const Authorities& in_force,
                                  const Adopt& adopt) {
  bool is_other = false;
  const auto judge = [&](BytesView file) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto next, Certificate::bundle_from_pem(file));
    if (have_the_same(next, in_force)) return {};
    DDSSEC_RETURN_IF_ERROR(withdrawn_.check(in_force, next));
    DDSSEC_RETURN_IF_ERROR(adopt(next));
    withdrawn_.note(in_force, next);
    is_other = true;
    return {};
  };
  DDSSEC_RETURN_IF_ERROR(file_.poll(now, judge));
  return is_other;
}

}  // namespace ddssec::pki
