#include "rtps/security/pre_shared_messages.hpp"

#include "rtps/security/peer_event.hpp"
#include "wire/vendor_name.hpp"

namespace ddssec::rtps {

// An attacker can cause key derivations in any number of names. An honest sender's turn comes
// eventually, and then its key is remembered.
Result<BytesView> PreSharedMessages::open(const Header& header, BytesView message,
                                          MutableBytes scratch, MonotonicTime now) {
  auto* const keys = own_.pre_shared_keys();
  if (keys == nullptr) {
    ++counters_.undecodable;
    return report_error(Code::secure_flags_unsupported, header,
                        "no pre-shared key: our governance has rtps_psk_protection_kind NONE", now);
  }
  if (!keys->remembers(message) && !derivations_.try_spend(now)) {
    ++counters_.undecodable;
    return fail(Code::psk_passphrase_unknown);
  }
  const auto size = keys->decode(message, scratch);
  if (size) return scratch.first(*size);
  ++counters_.undecodable;
  if (complaints_.try_spend(now))
    events_.raise(peer_event(size.error(), header.prefix.to_string()));
  return std::unexpected(size.error());
}

std::unexpected<Error> PreSharedMessages::missing_protection_error(const Header& header,
                                                                   MonotonicTime now) {
  ++counters_.unprotected;
  return report_error(
      Code::rtps_protection_missing, header,
      "a pre-shared key, as rtps_psk_protection_kind of our governance demands; Cyclone "
      "DDS and Fast DDS have none, so where they take part it must be NONE",
      now);
}

// After the event limit is reached, an invalid message costs no more than reading the budget.
std::unexpected<Error> PreSharedMessages::report_error(Code code, const Header& header,
                                                       std::string_view expected,
                                                       MonotonicTime now) {
  if (!complaints_.try_spend(now)) return fail(code);
  const auto sender = header.prefix.to_string();
  const Error error(code, {.document = "participant " + sender + " of " + name_of(header.vendor),
                           .expected = std::string(expected)});
  events_.raise(peer_event(error, sender));
  return std::unexpected(error);
}

Result<std::size_t> PreSharedMessages::protect(BytesView plain, MutableBytes out) {
  auto* const keys = own_.pre_shared_keys();
  if (keys == nullptr) return fail(Code::not_protected);
  return keys->encode(plain, out);
}

}  // namespace ddssec::rtps
