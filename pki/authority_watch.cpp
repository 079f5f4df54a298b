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
    : file_(of_bundle(std::move(what)), interval), file_in_force_(file_.file_id()) {}

// True if the file is the one that was adopted with fewer CAs, and has more octets at its end now.
bool AuthorityWatch::continues_cut_file(BytesView file, std::chrono::nanoseconds now) const {
  return cut_ && file_.file_id() == file_in_force_ && now - cut_->at <= kMaxWritingTime &&
         file.size() > cut_->octets && sha256(file.first(cut_->octets)) == cut_->content;
}

// Only a CA that the longer file has was cut off. One that it still lacks may have been withdrawn,
// but it may also come later.
Status AuthorityWatch::adopt_next(const FileOfNext& file, const Authorities& in_force,
                                  const Adopt& adopt) {
  auto withdrawn = withdrawn_;
  const bool continues = continues_cut_file(file.octets, file.now);
  const auto still_left = continues ? leaving(cut_->left, file.next) : Authorities();
  if (continues) withdrawn.forget(leaving(cut_->left, still_left));
  DDSSEC_RETURN_IF_ERROR(withdrawn.check(in_force, file.next));
  auto left = leaving(in_force, file.next);
  if (!left.empty() && !file_.is_as_at_last_poll()) {
    file_.decide_at_next_poll();
    return {};
  }
  DDSSEC_RETURN_IF_ERROR(adopt(file.next));
  withdrawn.note(in_force, file.next);
  withdrawn_ = std::move(withdrawn);
  const auto begin = continues ? cut_->at : file.now;
  left.insert(left.end(), still_left.begin(), still_left.end());
  cut_.reset();
  if (!left.empty() && file_in_force_ && file_.file_id() == file_in_force_)
    cut_ = {sha256(file.octets), file.octets.size(), begin, std::move(left)};
  return {};
}

Result<bool> AuthorityWatch::poll(std::chrono::nanoseconds now, const Authorities& in_force,
                                  const Adopt& adopt) {
  bool is_other = false;
  const auto take = [&](const Authorities& next) -> Status {
    DDSSEC_RETURN_IF_ERROR(adopt(next));
    is_other = true;
    return {};
  };
  const auto judge_file = [&](BytesView file) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto next, Certificate::bundle_from_pem(file));
    if (have_the_same(next, in_force)) return {};
    return adopt_next({file, next, now}, in_force, take);
  };
  const auto read = file_.poll(now, judge_file);
  // A file that has replaced the one that was written in place is whole, or is another attempt.
  if (file_.file_id() != file_in_force_) cut_.reset();
  if (read && *read) file_in_force_ = file_.file_id();
  DDSSEC_RETURN_IF_ERROR(read);
  return is_other;
}

}  // namespace ddssec::pki
