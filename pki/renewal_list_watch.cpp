#include "pki/renewal_list_watch.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

#include "base/rollback.hpp"
#include "base/uri_source.hpp"

namespace ddssec::pki {

namespace {

void append(RenewalList& to, RenewalList from) {
  std::ranges::move(from.certificates, std::back_inserter(to.certificates));
  std::ranges::move(from.permissions, std::back_inserter(to.permissions));
}

// Returns the entries of `former` that `next` lacks. A certificate of the same subject follows a
// former one. For permissions there is no such sign without judging them.
RenewalList entries_without(const RenewalList& former, const RenewalList& next) {
  std::set<Sha256Digest> subjects;
  for (const auto& one : next.certificates) subjects.insert(one.subject_digest());
  std::set<std::string_view> documents;
  for (const auto& one : next.permissions) documents.insert(as_text(one));
  RenewalList out;
  for (const auto& one : former.certificates)
    if (!subjects.contains(one.subject_digest())) out.certificates.push_back(one);
  for (const auto& one : former.permissions)
    if (!documents.contains(as_text(one))) out.permissions.push_back(one);
  return out;
}

}  // namespace

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
  for (const auto& place : places_) append(out, place.list);
  return out;
}

// Returns false if the list was adopted together with former entries that it lacks.
Result<bool> RenewalListWatch::adopt_list(Place& place, BytesView file, bool is_second_look,
                                          const Adopt& adopt) {
  DDSSEC_ASSIGN_OR_RETURN(auto list, RenewalList::parse(file));
  bool is_exact = true;
  if (!is_second_look) {
    auto lacking = entries_without(place.list, list);
    is_exact = lacking.is_empty();
    append(list, std::move(lacking));
  }
  std::swap(place.list, list);
  Rollback back([&] { std::swap(place.list, list); });
  DDSSEC_RETURN_IF_ERROR(adopt(merged_list()));
  back.release();
  return is_exact;
}

Result<bool> RenewalListWatch::read_place(Place& place, const Adopt& adopt) {
  Rollback again([&] { place.watch.force_change(); });
  const auto file = load_uri(place.watch.uri(), place.path, kMaxRenewalListOctets);
  const bool not_yet = !place.content && !file && file.error().code() == Code::file_not_found;
  const auto content = file ? sha256(*file) : Sha256Digest{};
  const bool is_second_look =
      file && std::exchange(place.last_read, std::optional(content)) == content;
  if (!file) place.last_read.reset();
  const bool is_other = file && place.content != content;
  Result<bool> exact = true;
  if (!file && !not_yet) exact = std::unexpected(file.error());
  if (is_other) exact = adopt_list(place, *file, is_second_look, adopt);
  if (exact && !*exact) {
    place.refusals.note_doubt();
    // Otherwise the former file would seem to be in force if it came back.
    place.content = Sha256Digest{};
    return false;
  }
  if (exact) {
    if (is_other) place.content = content;
    place.refusals.clear();
    again.release();
    return is_other;
  }
  if (!place.refusals.note_refusal(exact.error().code(), content)) return false;
  return std::unexpected(place.refusals.note(
      renewal_refused_error(refused_, exact.error(), place.path,
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

FileState RenewalListWatch::state() const {
  auto out = FileState::current;
  for (const auto& place : places_) out = std::max(out, place.refusals.state());
  return out;
}

}  // namespace ddssec::pki
