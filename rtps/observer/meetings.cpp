#include "rtps/observer/meetings.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>

#include <fmt/format.h>

#include "base/text.hpp"

namespace ddssec::rtps {
namespace {

// A step that is not answered for this long counts as unanswered: Cyclone DDS and Fast DDS repeat
// theirs after a second.
constexpr MonotonicTime kAnswerTimeout = std::chrono::milliseconds(2500);

// Properties of an identity token (DDS-Security 1.2, clause 10.3.2.1).
constexpr std::string_view kSubject = "dds.cert.sn", kIdentityCa = "dds.ca.sn";

const std::string* claim_of(const ObservedParticipant& participant, std::string_view property) {
  if (!participant.is_secured()) return nullptr;
  return spi::find_property(participant.data->identity_token->properties, property);
}

// An octet of a letter outside of ASCII, as a name has it in hexadecimal.
struct EscapedOctet {
  char octet;
  std::size_t length;  // of the escape
};

// Reads "\C3" (RFC 2253) or "\xC3" (OpenSSL's one-line form) at the beginning of the text.
std::optional<EscapedOctet> escaped_octet(std::string_view text) {
  for (const std::string_view begin : {"\\x", "\\"}) {
    if (!text.starts_with(begin)) continue;
    const auto digits = text.substr(begin.size(), 2);
    unsigned octet = 0;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), octet, 16);
    if (error == std::errc() && end == digits.data() + 2 && octet >= 0x80)
      return EscapedOctet{static_cast<char>(octet), begin.size() + 2};
  }
  return std::nullopt;
}

// True if an escaped character can be shown alone: what follows it does not look like another
// attribute, as in "CN=a\,O=b".
bool may_stand_alone(char escaped, std::string_view after) {
  constexpr std::string_view kSeparators = ",;+/";
  if (std::string_view("\"<># ").contains(escaped)) return true;
  return kSeparators.contains(escaped) &&
         !after.substr(0, after.find_first_of(kSeparators)).contains('=');
}

// Returns the name with as few escapes as a reader can do with. Control characters and backslashes
// stay escaped.
std::string readable(std::string_view name) {
  std::string out;
  while (!name.empty()) {
    std::size_t taken = 1;
    if (const auto octet = escaped_octet(name)) {
      out += octet->octet;
      taken = octet->length;
    } else if (name.front() == '\\' && name.size() > 1) {
      taken = 2;
      if (!may_stand_alone(name[1], name.substr(2))) out += '\\';
      out += name[1];
    } else {
      out += name.front();
    }
    name.remove_prefix(taken);
  }
  return printable(out);
}

struct Side {
  const GuidPrefix& prefix;
  const ObservedParticipant& participant;
  const HandshakeFlow& sent;  // what it sent to the other side

  std::string name() const { return name_of(prefix, participant); }
  const std::string* identity_ca() const { return claim_of(participant, kIdentityCa); }
  const std::string* permissions_ca() const {
    const auto& token = participant.data->permissions_token;
    return token ? spi::find_property(token->properties, "dds.perm_ca.sn") : nullptr;
  }
};

// Splits a name into its attributes, because vendors write names in several ways:
// "O=Example,CN=CA" and "/CN=CA/O=Example" are the same name.
std::vector<std::string_view> attributes_of(std::string_view name) {
  std::vector<std::string_view> out;
  for (std::size_t begin = 0; begin < name.size();) {
    const auto end = std::min(name.find_first_of(",/", begin), name.size());
    if (const auto part = trimmed(name.substr(begin, end - begin)); !part.empty())
      out.push_back(part);
    begin = end + 1;
  }
  std::ranges::sort(out);
  return out;
}

bool differ(const std::string* a, const std::string* b) {
  return a != nullptr && b != nullptr && attributes_of(*a) != attributes_of(*b);
}

std::string protection(const ObservedParticipant& participant) {
  const auto info = participant.data->security_info.value_or(spi::SecurityInfo{});
  const auto attributes = spi::attributes_in(info);
  if (!attributes) return "nothing that is valid";
  return fmt::format("rtps {}, discovery {}, liveliness {}{}{}", to_string(attributes->rtps),
                     to_string(attributes->discovery), to_string(attributes->liveliness),
                     is_protected(attributes->rtps_psk) ? ", pre-shared keys" : "",
                     attributes->is_key_revision_enabled ? ", key revision" : "");
}

double seconds(MonotonicTime time) { return std::chrono::duration<double>(time).count(); }

// Returns a contradiction between the announcements of the two participants.
std::optional<Finding> contradiction(const Side& a, const Side& b) {
  if (a.participant.is_secured() != b.participant.is_secured()) {
    const auto& without = a.participant.is_secured() ? b : a;
    return Finding{Rule::CAP001,
                   fmt::format("{} announces no identity, so {} does not authenticate it",
                               without.name(), (&without == &a ? b : a).name())};
  }
  const auto *ca_of_a = a.identity_ca(), *ca_of_b = b.identity_ca();
  if (differ(ca_of_a, ca_of_b))
    return Finding{Rule::CAP002,
                   fmt::format("the certificate of {} is issued by \"{}\", that of {} "
                               "by \"{}\"",
                               a.name(), *ca_of_a, b.name(), *ca_of_b)};
  if (differ(a.permissions_ca(), b.permissions_ca()))
    return Finding{Rule::CAP003,
                   fmt::format("the permissions of {} are signed by \"{}\", those of "
                               "{} by \"{}\"",
                               a.name(), *a.permissions_ca(), b.name(), *b.permissions_ca())};
  const auto info = [](const Side& side) {
    return side.participant.data->security_info.value_or(spi::SecurityInfo{});
  };
  if (!spi::is_compatible(info(a), info(b)))
    return Finding{Rule::CAP004,
                   fmt::format("{} announces {}; {} announces {}", a.name(),
                               protection(a.participant), b.name(), protection(b.participant))};
  return std::nullopt;
}

std::string times(const Sightings& seen) {
  return seen.count == 1 ? "once" : fmt::format("{} times", seen.count);
}

// Returns where the handshake that `a` began stopped. Empty if it did not stop, or not for long
// enough.
std::optional<Finding> standstill(const Side& a, const Side& b, MonotonicTime end) {
  const auto& request = a.sent.at(HandshakeStep::request);
  const auto& reply = b.sent.at(HandshakeStep::reply);
  const auto& final = a.sent.at(HandshakeStep::final);
  const auto waited = [&](const Sightings& seen) { return end - seen.first >= kAnswerTimeout; };
  if (final && waited(final)) {
    const auto& silent = a.sent.at(HandshakeStep::keys) ? b : a;
    return Finding{Rule::CAP012, fmt::format("the handshake of {} with {} is done, and {} sends no "
                                             "keys",
                                             a.name(), b.name(), silent.name())};
  }
  if (final) return std::nullopt;
  if (reply && waited(reply))
    return Finding{Rule::CAP011,
                   fmt::format("{} replied {} to the handshake of {}, which sends no final",
                               b.name(), times(reply), a.name())};
  if (request && !reply && waited(request))
    return Finding{Rule::CAP010,
                   fmt::format("{} sent its handshake request {} in {:.1f} s, and {} "
                               "does not reply",
                               a.name(), times(request), seconds(end - request.first), b.name())};
  return std::nullopt;
}

// Returns the doubt that applies to a pair of Fast DDS and Cyclone DDS. From 2.10 on, Fast DDS
// takes part in nothing before it has received a peer's data of DCPSParticipantsSecure, and Cyclone
// DDS 0.10 never writes there. No announcement reliably shows the version.
std::optional<Finding> doubt(const Side& a, const Side& b) {
  const auto are = [&](VendorId first, VendorId second) {
    return a.participant.vendor == first && b.participant.vendor == second;
  };
  const bool is_fast_first = are(kVendorFastDds, kVendorCyclone);
  if (!is_fast_first && !are(kVendorCyclone, kVendorFastDds)) return std::nullopt;
  const auto& [fast, cyclone] = is_fast_first ? std::tie(a, b) : std::tie(b, a);
  return Finding{Rule::CAP014,
                 fmt::format("{} is of Fast DDS, {} of Cyclone DDS: from Fast DDS 2.10 on, neither "
                             "discovers the other's topics",
                             fast.name(), cyclone.name())};
}

void set_state(ObservedMeeting& meeting, const Side& a, const Side& b, MonotonicTime end) {
  if (!a.participant.is_secured() && !b.participant.is_secured()) {
    meeting.state = MeetingState::unsecured;
    return;
  }
  const auto &keys_of_a = a.sent.at(HandshakeStep::keys),
             &keys_of_b = b.sent.at(HandshakeStep::keys);
  if (keys_of_a && keys_of_b) {
    meeting.state = MeetingState::authenticated;
    meeting.took = std::max(keys_of_a.first, keys_of_b.first) - meeting.met;
    meeting.finding = doubt(a, b);
    return;
  }
  meeting.finding = contradiction(a, b);
  if (!meeting.finding) meeting.finding = standstill(a, b, end);
  if (!meeting.finding) meeting.finding = standstill(b, a, end);
  const auto began = [](const Side& side) {
    return side.sent.at(HandshakeStep::request) || side.sent.at(HandshakeStep::reply);
  };
  if (!meeting.finding && !began(a) && !began(b) && end - meeting.met >= kAnswerTimeout)
    meeting.finding = Finding{
        Rule::CAP013, fmt::format("{} and {} announce themselves for {:.1f} s, and neither sends a "
                                  "handshake request",
                                  a.name(), b.name(), seconds(end - meeting.met))};
  if (meeting.finding) meeting.state = MeetingState::apart;
}

}  // namespace

std::string_view to_string(MeetingState state) {
  switch (state) {
    case MeetingState::unsecured:
      return "unsecured";
    case MeetingState::apart:
      return "apart";
    case MeetingState::under_way:
      return "under way";
    case MeetingState::authenticated:
      break;
  }
  return "authenticated";
}

std::string name_of(const GuidPrefix& prefix, const ObservedParticipant& participant) {
  if (participant.certificate) return readable(participant.certificate->subject);
  const auto* subject = claim_of(participant, kSubject);
  if (subject != nullptr && !subject->empty()) return readable(*subject);
  if (participant.data && !participant.data->entity_name.empty())
    return printable(participant.data->entity_name);
  return prefix.to_string();
}

std::string issuer_of(const ObservedParticipant& participant) {
  if (participant.certificate) return readable(participant.certificate->issuer);
  const auto* ca = claim_of(participant, kIdentityCa);
  return ca != nullptr ? readable(*ca) : "";
}

std::vector<ObservedMeeting> meetings_of(const Observer& observer) {
  std::vector<ObservedMeeting> out;
  const auto& all = observer.participants();
  for (auto a = all.begin(); a != all.end(); ++a)
    for (auto b = std::next(a); b != all.end() && out.size() < kMaxMeetings; ++b) {
      if (!a->second.data || !b->second.data || a->second.domain != b->second.domain) continue;
      ObservedMeeting meeting{.a = a->first, .b = b->first};
      meeting.met = std::max(a->second.messages.first, b->second.messages.first);
      const auto end =
          std::min(a->second.has_left ? a->second.messages.last : observer.datagrams().last,
                   b->second.has_left ? b->second.messages.last : observer.datagrams().last);
      set_state(meeting, {a->first, a->second, observer.flow(a->first, b->first)},
                {b->first, b->second, observer.flow(b->first, a->first)}, end);
      out.push_back(std::move(meeting));
    }
  return out;
}

std::optional<Finding> all_in_different_domains(const Observer& observer) {
  constexpr std::size_t kMax = 5;
  std::set<DomainId> domains;
  std::string names;
  for (const auto& [prefix, participant] : observer.participants()) {
    if (!participant.data || participant.domain < 0) continue;
    if (!domains.insert(participant.domain).second) return std::nullopt;
    if (domains.size() <= kMax)
      names += fmt::format("{}{} in domain {}", names.empty() ? "" : ", ",
                           name_of(prefix, participant), participant.domain);
  }
  if (domains.size() < 2) return std::nullopt;
  return Finding{Rule::CAP005, fmt::format("no two participants are in the same domain: {}{}",
                                           names, domains.size() > kMax ? ", ..." : "")};
}

std::vector<Finding> leaks_of(const Observer& observer) {
  std::vector<Finding> out;
  for (const auto& [prefix, participant] : observer.participants()) {
    if (!participant.is_secured()) continue;
    const auto name = name_of(prefix, participant);
    if (const auto& topics = participant.clear_topics; !topics.empty())
      out.push_back(
          {Rule::CAP020, fmt::format("{} announces {} of its topics in the clear, such as "
                                     "\"{}\"",
                                     name, topics.size(), topics.begin()->first)});
    if (participant.clear_samples > 0)
      out.push_back({Rule::CAP021, fmt::format("{} sent {} samples in the clear", name,
                                               participant.clear_samples)});
  }
  return out;
}

}  // namespace ddssec::rtps
