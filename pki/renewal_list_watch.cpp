#include "pki/renewal_list_watch.hpp"

#include <utility>

#include "base/rollback.hpp"
#include "base/uri_source.hpp"

namespace ddssec::pki {

RenewalListWatch::RenewalListWatch(const std::vector<std::string>& uris,
                                   std::chrono::seconds interval, Code refused)
    : refused_(refused) {
  for (const auto& uri : uris) {
    FileWatch watch(uri, interval);
    auto path = file_named_by(watch.uri());
    if (path) places_.push_back({.watch = std::move(watch), .path = *std::move(path)});
  }
}

RenewalList RenewalListWatch::merged_list() const {
  RenewalList out;
  for (const auto& place : places_) {
    const auto& [certificates, permissions] = place.list;
    out.certificates.insert(out.certificates.end(), certificates.begin(), certificates.end());
    out.permissions.insert(out.permissions.end(), permissions.begin(), permissions.end());
  }
  return out;
}

Status RenewalListWatch::judge(Place& place, BytesView file, const Adopt& adopt) {
  DDSSEC_ASSIGN_OR_RETURN(auto list, RenewalList::parse(file));
  std::swap(place.list, list);
  Rollback back([&] { std::swap(place.list, list); });
  DDSSEC_RETURN_IF_ERROR(adopt(merged_list()));
  back.release();
  return {};
}

Result<bool> RenewalListWatch::read_place(Place& place, const Adopt& adopt) {
  Rollback again([&] { place.watch.force_change(); });
  const auto file = load_uri(place.watch.uri(), place.path, kMaxRenewalListOctets);
  const bool not_yet = !place.content && !file && file.error().code() == Code::file_not_found;
  const auto content = file ? sha256(*file) : Sha256Digest{};
  const bool is_other = file && place.content != content;
  Status status;
  if (!file && !not_yet) status = std::unexpected(file.error());
  if (is_other) status = judge(place, *file, adopt);
  if (status) {
    if (is_other) place.content = content;
    place.refusals.clear();
    again.release();
    return is_other;
  }
  if (!place.refusals.note_refusal(status.error().code(), content)) return false;
  return std::unexpected(place.refusals.note(
      renewal_refused_error(refused_, status.error(), place.path,
                            place.content ? "the list read before stays in force" : "")));
}

Result<bool> RenewalListWatch::poll(std::chrono::nanoseconds now, const Adopt& adopt) {
  // A fault in one file must not prevent the others from being read. The first error, or else the
  // first change, is returned.
  Result<bool> out = false;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (!places_[i].watch.may_have_changed(now)) continue;
    auto taken = read_place(places_[i], adopt);
    if (taken && *taken) taken_from_ = i;
    if (out && (!taken || *taken)) out = std::move(taken);
  }
  return out;
}

void RenewalListWatch::force_poll() {
  for (auto& place : places_) place.watch.force_poll();
}

void RenewalListWatch::reevaluate() {
  for (auto& place : places_) {
    place.content.reset();
    place.watch.force_poll();
  }
}

std::string RenewalListWatch::path() const {
  return places_.empty() ? std::string() : places_[taken_from_].path;
}

std::optional<Error> RenewalListWatch::refused() const {
  for (const auto& place : places_)
    if (place.refusals.refused()) return place.refusals.refused();
  return std::nullopt;
}

}  // namespace ddssec::pki
