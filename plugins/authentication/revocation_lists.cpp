#include "plugins/authentication/revocation_lists.hpp"

#include <algorithm>
#include <utility>

#include "base/rollback.hpp"
#include "pki/certificate_source.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

namespace property = spi::property;

// The name in sros2's keystores and in the folders of ddssec.
constexpr std::string_view kUsualName = "crl.pem";
// The longest description of many lists in an event.
constexpr std::size_t kMaxDescription = 512;

Result<std::vector<pki::Crl>> parse(BytesView octets, std::string_view uri) {
  DDSSEC_ASSIGN_OR_RETURN(auto lists, pki::Crl::all_from(octets));
  // A file without any list must not count as an empty list.
  if (lists.empty()) return fail(Code::crl_file_empty, {.found = std::string(uri.substr(0, 256))});
  return lists;
}

// Returns the places of a list that no property names: beside the certificate that the CA issued,
// or beside the CA.
std::vector<std::string> usual_places(const spi::PropertyList& properties) {
  std::vector<std::string> uris;
  for (const auto name : {property::kIdentityCertificate, property::kIdentityCa}) {
    const auto file = file_named_by(absolute_uri(spi::property_value(properties, name)));
    if (!file) continue;
    const auto slash = file->rfind('/');
    const auto folder = slash == std::string::npos ? std::string() : file->substr(0, slash + 1);
    auto uri = "file:" + folder + std::string(kUsualName);
    if (std::ranges::find(uris, uri) == uris.end()) uris.push_back(std::move(uri));
  }
  return uris;
}

std::string describe(const pki::Crl& crl) {
  const auto number = crl.number();
  return (number ? "number " + to_string(*number) + " of " : "a list of ") +
         to_string(crl.this_update());
}

// While a CA is replaced, two CAs have the same name. The key distinguishes them.
std::string signer_of(const pki::Crl& crl) {
  const auto key = crl.authority_key_id().substr(0, 8);
  return crl.issuer() + (key.empty() ? "" : " (key " + key + ")");
}

// If two CAs have the same name, either one may have signed the list.
Status check_signed(const pki::Crl& crl, const std::vector<pki::Certificate>& anchors,
                    WallTime now) {
  Status status;
  for (const auto& ca : anchors) {
    if (!crl.is_named_after(ca)) continue;
    status = crl.check(ca, now);
    if (status) return status;
  }
  return status;
}

// If two CAs have the same name, each must continue with its own list.
Status check_replaced(const pki::Crl& held, const std::vector<pki::Crl>& lists,
                      const std::vector<pki::Certificate>& anchors, WallTime now) {
  const auto is_of_its_ca = [&](const pki::Crl& crl) {
    return pki::have_common_signer(crl, held, anchors);
  };
  const bool is_replaced = std::ranges::any_of(
      lists, [&](const auto& crl) { return crl.may_replace_at(held, now) && is_of_its_ca(crl); });
  if (is_replaced) return {};
  const auto found = std::ranges::find_if(lists, is_of_its_ca);
  if (found == lists.end())
    return fail(Code::crl_missing, {.expected = "a list of " + held.issuer()});
  return fail(Code::crl_older, {.field = held.issuer(),
                                .expected = describe(held) + " or later",
                                .found = describe(*found)});
}

bool is_newer(const pki::Crl& crl, const pki::Crl& other,
              const std::vector<pki::Certificate>& anchors, WallTime now) {
  return crl.may_replace_at(other, now) && !other.may_replace_at(crl, now) &&
         pki::have_common_signer(crl, other, anchors);
}

// True if both are the same list. If there is not enough memory, they count as different, so that a
// new one is judged again.
bool is_same_list(const pki::Crl& a, const pki::Crl& b) {
  const auto text = a.pem();
  return !text.empty() && text == b.pem();
}

// Returns the lists without those for which `lists` has a newer one of the same CA, or the same one
// again. A list that no CA among `anchors` signed replaces none.
std::vector<pki::Crl> newest_of(const std::vector<pki::Crl>& lists,
                                const std::vector<pki::Certificate>& anchors, WallTime now) {
  std::vector<pki::Crl> out;
  for (const auto& crl : lists) {
    const auto makes_needless = [&](const auto& other) {
      return is_newer(other, crl, anchors, now);
    };
    const auto is_same = [&](const auto& other) { return is_same_list(other, crl); };
    if (std::ranges::none_of(lists, makes_needless) && std::ranges::none_of(out, is_same))
      out.push_back(crl);
  }
  return out;
}

}  // namespace

Status check_renewal(const std::vector<pki::Crl>& lists, const std::vector<pki::Crl>& former,
                     const std::vector<pki::Certificate>& anchors, WallTime now) {
  // A list in force stays as it is, also if it has ended or its CA was replaced. If it were judged
  // again, one CA without a new list would keep back the lists of all others.
  for (const auto& crl : lists) {
    const auto is_this = [&](const auto& held) { return is_same_list(held, crl); };
    if (std::ranges::none_of(former, is_this))
      DDSSEC_RETURN_IF_ERROR(check_signed(crl, anchors, now));
  }
  // If a CA has been replaced by one of the same name, its list has no effect any more.
  for (const auto& held : former)
    if (std::ranges::any_of(anchors, [&](const auto& ca) { return held.is_signed_by(ca); }))
      DDSSEC_RETURN_IF_ERROR(check_replaced(held, lists, anchors, now));
  return {};
}

RevocationLists::Place::Place(std::string_view from, std::chrono::seconds interval)
    : watch(from, interval), path(file_named_by(watch.uri()).value_or("")) {}

Result<RevocationLists> RevocationLists::load(const spi::PropertyList& properties,
                                              const std::vector<pki::Certificate>& anchors,
                                              WallTime now) {
  RevocationLists out;
  DDSSEC_ASSIGN_OR_RETURN(out.interval_, spi::files_poll_interval(properties));
  const auto must = spi::property_value(properties, property::kCrl);
  const auto may = spi::property_value(properties, property::kLaterCrl);
  if (!must.empty() && !may.empty())
    return fail(
        Code::property_without_effect,
        {.document = std::string(property::kLaterCrl),
         .note = std::string(property::kCrl) + " names the list already",
         .hint = "name one of the two only: the list that must exist when the participant is "
                 "made, or one that may come later"});
  const auto name = must.empty() ? property::kLaterCrl : property::kCrl;
  if (!must.empty() || !may.empty()) {
    out.places_.emplace_back(must.empty() ? may : must, out.interval_);
    DDSSEC_RETURN_IF_ERROR(
        out.read_first(out.places_.front(), name,
                       must.empty() ? MissingFile::may_come_later : MissingFile::refused));
    out.lists_ = out.together(anchors, now);
    return out;
  }
  if (!spi::property_value(properties, property::kTrustedCaDir).empty()) return out;
  for (const auto& uri : usual_places(properties)) out.places_.emplace_back(uri, out.interval_);
  for (auto& place : out.places_)
    DDSSEC_RETURN_IF_ERROR(read_first(place, place.path, MissingFile::may_come_later));
  out.lists_ = out.together(anchors, now);
  return out;
}

// Reads a place for the first time. `name` is the name of the file in errors.
Status RevocationLists::read_first(Place& place, std::string_view name, MissingFile missing) {
  const auto octets = ddssec::load_uri(place.watch.uri(), name, pki::kMaxDocumentOctets);
  if (!octets && missing == MissingFile::may_come_later &&
      octets.error().code() == Code::file_not_found)
    return {};
  if (!octets) return std::unexpected(octets.error());
  DDSSEC_ASSIGN_OR_RETURN(
      place.lists, with_default_document(parse(*octets, place.watch.uri()), std::string(name)));
  place.content = sha256(*octets);
  return {};
}

// Returns the lists in force if every place counts: the newest list of each CA.
std::vector<pki::Crl> RevocationLists::together(const std::vector<pki::Certificate>& anchors,
                                                WallTime now) const {
  std::vector<pki::Crl> all;
  for (const auto& place : places_) all.insert(all.end(), place.lists.begin(), place.lists.end());
  return newest_of(all, anchors, now);
}

std::string RevocationLists::path() const {
  if (places_.empty()) return {};
  const auto is_in_force = [&](const pki::Crl& crl) {
    return std::ranges::any_of(lists_, [&](const auto& one) { return one.is_copy_of(crl); });
  };
  std::string paths;
  for (const auto& place : places_)
    if (std::ranges::any_of(place.lists, is_in_force))
      paths += (paths.empty() ? "" : " and ") + place.path;
  return paths.empty() ? places_.front().path : paths;
}

const pki::Crl* RevocationLists::first_to_end(std::optional<WallTime> end) const {
  const auto found = std::ranges::find_if(
      lists_, [&](const auto& list) { return end && list.next_update() == end; });
  return found == lists_.end() ? nullptr : &*found;
}

std::optional<Error> RevocationLists::absence() const {
  if (!lists_.empty() || path().empty()) return std::nullopt;
  std::string paths;
  for (const auto& place : places_) paths += (paths.empty() ? "" : " and ") + place.path;
  const auto seconds = std::to_string(interval_.count());
  return Error(
      Code::no_revocation_list,
      {.note = interval_.count() == 0 ? paths + " is not looked for, since " +
                                            std::string(property::kFilesPollInterval) + " is 0"
                                      : paths + " is looked for every " + seconds + " s"});
}

std::string RevocationLists::description() const {
  std::string text;
  for (const auto& crl : lists_)
    text += (text.empty() ? "" : "; ") + describe(crl) + " by " + signer_of(crl);
  return text.substr(0, kMaxDescription);
}

Result<bool> RevocationLists::poll(const Clock& clock, const std::vector<pki::Certificate>& anchors,
                                   const Accept& accept) {
  // A fault in one place must not prevent another place from being read.
  Result<bool> out = false;
  for (auto& place : places_) {
    if (!place.watch.may_have_changed(clock.monotonic())) continue;
    auto renewed = poll_place(place, {anchors, clock.calendar_seconds(), accept});
    if (!renewed) {
      if (out) out = std::move(renewed);
      continue;
    }
    if (!*renewed) continue;
    // The newest list of another place may now be older than this one, and a fault there has not
    // been reported yet.
    for (auto& other : places_) {
      other.watch.force_change();
      other.refusals.report_again();
    }
    return true;
  }
  return out;
}

Result<bool> RevocationLists::poll_place(Place& place, const Question& question) {
  Rollback again([&] { place.watch.force_change(); });
  const auto octets = ddssec::load_uri(place.watch.uri(), place.path, pki::kMaxDocumentOctets);
  const bool not_yet =
      place.lists.empty() && !octets && octets.error().code() == Code::file_not_found;
  const auto content = octets ? sha256(*octets) : Sha256Digest{};
  Result<bool> taken = false;
  if (!octets && !not_yet) taken = std::unexpected(octets.error());
  if (octets && content != place.content) taken = adopt_lists(*octets, place, question);
  if (taken && octets) place.content = content;
  if (taken && !*taken)
    if (const auto behind = check_current(place, question); !behind)
      taken = std::unexpected(behind.error());
  if (!taken) return refuse(place, taken.error(), content);
  place.refusals.clear();
  again.release();
  return taken;
}

Result<RevocationLists> RevocationLists::read(const std::vector<pki::Certificate>& anchors,
                                              WallTime now) const {
  auto out = *this;
  for (auto& place : out.places_)
    DDSSEC_RETURN_IF_ERROR(
        read_first(place, place.path,
                   place.lists.empty() ? MissingFile::may_come_later : MissingFile::refused));
  out.lists_ = out.together(anchors, now);
  return out;
}

// Judges the octets of a place. Returns true if other lists came into force.
Result<bool> RevocationLists::adopt_lists(BytesView octets, Place& place,
                                          const Question& question) {
  DDSSEC_ASSIGN_OR_RETURN(auto lists, parse(octets, place.watch.uri()));
  std::swap(place.lists, lists);
  Rollback back([&] { std::swap(place.lists, lists); });
  auto next = together(question.anchors, question.now);
  const bool is_other = !std::ranges::equal(next, lists_, is_same_list);
  if (is_other) DDSSEC_RETURN_IF_ERROR(question.accept(next));
  lists_ = std::move(next);
  back.release();
  return is_other;
}

// An older list than that of another place does no harm here, but it harms a participant that has
// only this place.
Status RevocationLists::check_current(const Place& place, const Question& question) const {
  for (const auto& crl : place.lists)
    for (const auto& held : lists_)
      if (is_newer(held, crl, question.anchors, question.now))
        return fail(Code::crl_copy_older, {.field = crl.issuer(),
                                           .expected = describe(held) + " or later",
                                           .found = describe(crl),
                                           .note = "the newer list, from " + path() + ", counts"});
  return {};
}

Result<bool> RevocationLists::refuse(Place& place, const Error& error,
                                     const Sha256Digest& content) {
  if (!place.refusals.note_refusal(error.code(), content)) return false;
  if (auto folder = folder_refused(error, place.path))
    return std::unexpected(place.refusals.note(*std::move(folder)));
  auto details = error.details();
  details.document = place.path;
  if (error.code() != Code::crl_copy_older)
    details.note += (details.note.empty() ? "" : "; ") +
                    std::string(lists_.empty() ? "there is still no revocation list in force"
                                               : "the lists read before stay in force");
  return std::unexpected(place.refusals.note(Error(error.code(), std::move(details))));
}

FileState RevocationLists::state() const {
  auto out = FileState::current;
  for (const auto& place : places_) out = std::max(out, place.refusals.state());
  return out;
}

std::optional<Error> RevocationLists::refused() const {
  // A list that only begins later must not hide one that is wrong.
  const auto worst = std::ranges::max_element(places_, {}, [](const Place& place) {
    return std::pair(place.refusals.state(), bool(place.refusals.refused()));
  });
  return worst == places_.end() ? std::nullopt : worst->refusals.refused();
}

}  // namespace ddssec::authentication
