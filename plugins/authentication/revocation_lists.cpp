#include "plugins/authentication/revocation_lists.hpp"

#include <algorithm>
#include <utility>

#include "base/rollback.hpp"
#include "pki/source.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

namespace property = spi::property;

/// What an event says of many lists.
constexpr std::size_t kMostDescription = 512;

std::string value_of(const spi::PropertyList& properties, std::string_view name) {
  const std::string* value = spi::find_property(properties, name);
  return value == nullptr ? std::string() : *value;
}

Result<std::vector<pki::Crl>> parse(BytesView octets, std::string_view uri) {
  auto lists = DDSSEC_TRY(pki::Crl::all_from(octets));
  // A file that lists nobody because it is no list must not look like "nobody is revoked".
  if (lists.empty()) return fail(Code::crl_file_empty, {.found = std::string(uri.substr(0, 256))});
  return lists;
}

std::string describe(const pki::Crl& crl) {
  const auto number = crl.number();
  return (number ? "number " + std::to_string(*number) + " of " : "a list of ") +
         to_string(crl.this_update());
}

/// Of two CAs of one name either may have signed it.
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

Status check_superseded(const pki::Crl& held, const std::vector<pki::Crl>& lists) {
  if (std::ranges::any_of(lists, [&](const auto& crl) { return crl.supersedes(held); })) return {};
  const auto found = std::ranges::find(lists, held.issuer(), &pki::Crl::issuer);
  if (found == lists.end())
    return fail(Code::crl_missing, {.expected = "a list of " + held.issuer()});
  return fail(Code::crl_older, {.field = held.issuer(),
                                .expected = describe(held) + " or later",
                                .found = describe(*found)});
}

}  // namespace

Status check_renewal(const std::vector<pki::Crl>& lists, const std::vector<pki::Crl>& former,
                     const std::vector<pki::Certificate>& anchors, WallTime now) {
  for (const auto& crl : lists) DDSSEC_TRY(check_signed(crl, anchors, now));
  for (const auto& held : former)
    if (std::ranges::any_of(anchors, [&](const auto& ca) { return held.is_named_after(ca); }))
      DDSSEC_TRY(check_superseded(held, lists));
  return {};
}

RevocationLists::RevocationLists(std::string uri, std::chrono::seconds interval)
    : uri_(std::move(uri)), path_(file_named_by(uri_).value_or("")), watch_(uri_, interval) {}

Result<RevocationLists> RevocationLists::load(const spi::PropertyList& properties) {
  const auto interval = DDSSEC_TRY(spi::files_poll_interval(properties));
  const bool may_come_later = value_of(properties, property::kCrl).empty();
  const auto name = may_come_later ? property::kLaterCrl : property::kCrl;
  RevocationLists out(value_of(properties, name), interval);
  if (out.uri_.empty()) return out;
  const auto octets = ddssec::load(out.uri_, name, pki::kMostDocumentOctets);
  if (!octets && may_come_later && octets.error().code() == Code::file_not_found) return out;
  if (!octets) return std::unexpected(octets.error());
  auto lists = parse(*octets, out.uri_);
  if (!lists) return std::unexpected(lists.error().in(std::string(name)));
  out.lists_ = *std::move(lists);
  out.content_ = sha256(*octets);
  return out;
}

std::string RevocationLists::description() const {
  std::string text;
  for (const auto& crl : lists_)
    text += (text.empty() ? "" : "; ") + describe(crl) + " by " + crl.issuer();
  return text.substr(0, kMostDescription);
}

Result<bool> RevocationLists::look(std::chrono::nanoseconds now, const Accept& accept) {
  if (!watch_.may_have_changed(now)) return false;
  Rollback again([&] { watch_.look_again(); });
  const auto octets = ddssec::load(uri_, path_, pki::kMostDocumentOctets);
  const bool not_yet = lists_.empty() && !octets && octets.error().code() == Code::file_not_found;
  const auto content = octets ? sha256(*octets) : Sha256Digest{};
  Result<bool> taken = false;
  if (!octets && !not_yet) taken = std::unexpected(octets.error());
  if (octets && content != content_) taken = take(*octets, accept);
  if (!taken) return refuse(taken.error(), content);
  if (*taken) content_ = content;
  was_refused_ = false;
  told_.reset();
  again.release();
  return taken;
}

Result<bool> RevocationLists::take(BytesView octets, const Accept& accept) {
  auto lists = DDSSEC_TRY(parse(octets, uri_));
  DDSSEC_TRY(accept(lists));
  lists_ = std::move(lists);
  return true;
}

Result<bool> RevocationLists::refuse(const Error& error, const Sha256Digest& content) {
  const bool is_lasting = std::exchange(was_refused_, true);
  const Refusal refusal{error.code(), content};
  if (!is_lasting || told_ == refusal) return false;
  told_ = refusal;
  auto details = error.details();
  details.document = path_;
  details.note +=
      (details.note.empty() ? "" : "; ") + std::string("the lists read before stay in force");
  return fail(error.code(), std::move(details));
}

}  // namespace ddssec::authentication
