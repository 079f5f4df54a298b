#include "plugins/authentication/participant_data.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/reader.hpp"
#include "plugins/authentication/identity_token.hpp"
#include "wire/parameter_list.hpp"
#include "wire/vendor.hpp"

namespace ddssec::authentication {
namespace {

std::unexpected<Error> malformed_error(std::string found) {
  return fail(Code::participant_data_malformed, {.field = "c.pdata", .found = std::move(found)});
}

// Reads the next parameter; empty at the end of the list, which may have no sentinel.
Result<std::optional<rtps::Parameter>> next_parameter(rtps::ParameterReader& list) {
  if (list.at_end()) return std::nullopt;
  auto parameter = list.next_or_pad();
  if (parameter) return parameter;
  return malformed_error(parameter.error().code() == Code::truncated
                             ? "a list that ends within a parameter"
                             : "a length that is not a multiple of 4");
}

// Reads an RTPS Locator_t (RTPS 9.3.2.3): kind, port, 16 octets of address.
std::optional<spi::UdpAddress> unicast_address(BytesView locator) {
  constexpr std::int32_t kUdpV4 = 1, kUdpV6 = 2;
  Reader reader(locator, Endian::big);
  const auto kind = reader.read<std::int32_t>();
  const auto port = reader.read<std::uint32_t>();
  const auto address = reader.read_bytes(16);
  if (!kind || !port || !address) return std::nullopt;
  if ((*kind != kUdpV4 && *kind != kUdpV6) || *port == 0 || *port > 0xffff) return std::nullopt;
  spi::UdpAddress out{.is_ipv6 = *kind == kUdpV6, .port = static_cast<std::uint16_t>(*port)};
  std::ranges::copy(*address, out.address.begin());
  const auto first = out.address[out.is_ipv6 ? 0 : 12];
  const bool is_unicast = out.is_ipv6 ? first != 0 && first != 0xff : first != 0 && first < 224;
  const bool is_loopback_v6 =
      out.is_ipv6 &&
      out.address == std::array<std::uint8_t, 16>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  if (!is_unicast && !is_loopback_v6) return std::nullopt;
  return out;
}

// Reads a CDR string; empty if it is malformed.
std::string text_in(BytesView value) {
  Reader reader(value, Endian::big);
  const auto size = reader.read<std::uint32_t>();
  const auto octets = size ? reader.read_bytes(*size) : Result<BytesView>(BytesView());
  if (!octets || octets->empty()) return {};
  return std::string(as_text(octets->back() == 0 ? octets->first(octets->size() - 1) : *octets));
}

}  // namespace

Result<Guid> participant_guid_in(BytesView participant_data) {
  rtps::ParameterReader list(participant_data, Endian::big);
  std::optional<Guid> found;
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto parameter, next_parameter(list));
    if (!parameter) break;

    if (parameter->id != pid::kParticipantGuid) continue;
    if (parameter->value.size() < Guid::size) return malformed_error("a short PARTICIPANT_GUID");
    const auto guid = Guid::from(parameter->value);
    if (found && *found != guid) return malformed_error("two different PARTICIPANT_GUIDs");
    found = guid;
  }
  if (!found) return fail(Code::participant_guid_missing, {.field = "c.pdata"});
  return *found;
}

spi::CipherMask ciphers_in_participant_data(BytesView participant_data) {
  rtps::ParameterReader list(participant_data, Endian::big);
  std::optional<spi::Token> found;
  for (;;) {
    const auto parameter = next_parameter(list);
    if (!parameter || !*parameter) break;
    if ((*parameter)->id != pid::kIdentityToken) continue;
    Reader value((*parameter)->value, Endian::big);
    auto token = spi::read_token(value);
    if (!token || found) return spi::kStandardCiphers;
    found = std::move(*token);
  }
  return found ? announced_ciphers(*found) : spi::kStandardCiphers;
}

std::uint32_t builtin_endpoints_in_participant_data(BytesView participant_data) {
  rtps::ParameterReader list(participant_data, Endian::big);
  std::optional<std::uint32_t> found;
  for (;;) {
    const auto parameter = next_parameter(list);
    if (!parameter || !*parameter) break;
    if ((*parameter)->id != pid::kBuiltinEndpointSet) continue;
    const auto set = Reader((*parameter)->value, Endian::big).read<std::uint32_t>();
    if (!set || found) return 0;
    found = *set;
  }
  return found.value_or(0);
}

bool is_of_fast_dds(BytesView participant_data) {
  rtps::ParameterReader list(participant_data, Endian::big);
  std::optional<bool> found;
  for (;;) {
    const auto parameter = next_parameter(list);
    if (!parameter || !*parameter) break;
    if ((*parameter)->id != pid::kVendorId) continue;
    const auto& value = (*parameter)->value;
    if (found || value.size() < rtps::VendorId::size) return false;
    found = rtps::VendorId::from(value) == rtps::kVendorFastDds;
  }
  return found.value_or(false);
}

SignedDomain domain_in_participant_data(BytesView participant_data) {
  rtps::ParameterReader list(participant_data, Endian::big);
  constexpr std::array kIds = {pid::kVendorId, pid::kDomainId, pid::kDomainTag};
  std::array<bool, kIds.size()> seen{};
  SignedDomain out{.id = {}, .tag = {}, .may_lack_tag = true};
  for (;;) {
    const auto parameter = next_parameter(list);
    if (!parameter || !*parameter) break;
    const auto& [id, value, endian] = **parameter;
    if (const auto known = std::ranges::find(kIds, id); known != kIds.end())
      out.is_ambiguous |= std::exchange(seen[static_cast<std::size_t>(known - kIds.begin())], true);
    if (id == pid::kVendorId && value.size() >= rtps::VendorId::size) {
      const auto vendor = rtps::VendorId::from(value);
      out.may_lack_tag = vendor != rtps::kVendorCyclone && vendor != rtps::kVendorDdssec;
    } else if (id == pid::kDomainId) {
      const auto number = Reader(value, endian).read<std::uint32_t>();
      if (number) out.id = *number;
    } else if (id == pid::kDomainTag) {
      out.tag = text_in(value);
    }
  }
  return out;
}

Status check_same_domain(const SignedDomain& peer, const SignedDomain& own) {
  const bool is_same_id = !peer.id || !own.id || *peer.id == *own.id;
  const bool is_same_tag = peer.tag == own.tag || (peer.tag.empty() && peer.may_lack_tag);
  if (is_same_id && is_same_tag && !peer.is_ambiguous) return {};
  const auto text = [&](const SignedDomain& one) {
    return fmt::format("domain {}, tag \"{}\"{}", one.id.value_or(own.id.value_or(0)), one.tag,
                       one.is_ambiguous ? ", with a parameter that comes twice" : "");
  };
  return fail(Code::rtps_domain_differs, {.document = "what the peer signed",
                                          .field = "DOMAIN_ID and DOMAIN_TAG of c.pdata",
                                          .expected = text(own),
                                          .found = text(peer)});
}

std::vector<spi::UdpAddress> addresses_in_participant_data(BytesView participant_data) {
  rtps::ParameterReader list(participant_data, Endian::big);
  std::vector<spi::UdpAddress> out;
  while (out.size() < kMaxAddresses) {
    const auto parameter = next_parameter(list);
    if (!parameter || !*parameter) break;
    if ((*parameter)->id != pid::kMetatrafficUnicastLocator) continue;
    const auto address = unicast_address((*parameter)->value);
    if (address && std::ranges::find(out, *address) == out.end()) out.push_back(*address);
  }
  return out;
}

}  // namespace ddssec::authentication
