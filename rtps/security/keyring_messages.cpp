// Keyring, the part that protects whole messages: by participants' keys, or by the key that the
// domain shares (DDS-Security 1.2 10.4.1.2.5.8).
#include "rtps/security/keyring.hpp"
#include "wire/submessage.hpp"
#include "wire/vendor_name.hpp"

namespace ddssec::rtps {
namespace {

bool begins_protected(BytesView message) {
  constexpr auto kProtected = static_cast<std::uint8_t>(SubmessageId::secure_rtps_prefix);
  return message.size() > kHeaderSize && message[kHeaderSize] == kProtected;
}

}  // namespace

Result<Keyring::OpenMessage> Keyring::open_message(const Header& header, BytesView message,
                                                   MutableBytes scratch, MonotonicTime now) {
  if (!begins_protected(message)) {
    if (own_.pre_shared_keys() != nullptr) return refuse_bare(header, now);
    return OpenMessage{message};
  }
  if (spi::has_pre_shared_key_flag(message))
    return OpenMessage{DDSSEC_TRY(open_pre_shared(header, message, scratch, now))};
  const auto remote = remotes_.find(header.prefix);
  if (remote == remotes_.end()) return undecodable(Error(Code::crypto_not_matched), header.prefix);
  const auto size =
      transform().decode_rtps_message(own_.crypto(), remote->second.crypto, message, scratch);
  if (!size) return undecodable(size.error(), header.prefix);
  return OpenMessage{scratch.first(*size), true};
}

// Anybody can make us derive keys, in as many names as they like: an honest sender's turn comes,
// and then it is remembered.
Result<BytesView> Keyring::open_pre_shared(const Header& header, BytesView message,
                                           MutableBytes scratch, MonotonicTime now) {
  auto* const keys = own_.pre_shared_keys();
  if (keys == nullptr) {
    ++counters_.undecodable;
    return complain(Code::secure_flags_unsupported, header,
                    "no pre-shared key: our governance has rtps_psk_protection_kind NONE", now);
  }
  if (!keys->remembers(message) && !derivations_.take(now)) {
    ++counters_.undecodable;
    return fail(Code::psk_passphrase_unknown);
  }
  const auto size = keys->decode(message, scratch);
  if (size) return scratch.first(*size);
  ++counters_.undecodable;
  if (complaints_.take(now)) events_.raise(Event(size.error(), {}, header.prefix.to_string()));
  return std::unexpected(size.error());
}

std::unexpected<Error> Keyring::refuse_bare(const Header& header, MonotonicTime now) {
  ++counters_.unprotected;
  return complain(
      Code::rtps_protection_missing, header,
      "a pre-shared key, as rtps_psk_protection_kind of our governance demands; Cyclone "
      "DDS and Fast DDS have none, so where they take part it must be NONE",
      now);
}

// Who sends garbage costs us no more than a look at the time.
std::unexpected<Error> Keyring::complain(Code code, const Header& header, std::string_view expected,
                                         MonotonicTime now) {
  if (!complaints_.take(now)) return fail(code);
  const auto sender = header.prefix.to_string();
  const Error error(code, {.document = "participant " + sender + " of " + name_of(header.vendor),
                           .expected = std::string(expected)});
  events_.raise(Event(error, {}, sender));
  return std::unexpected(error);
}

Result<std::size_t> Keyring::protect_message(Wrap wrap, const GuidPrefix& receiver, BytesView plain,
                                             MutableBytes out) {
  if (wrap == Wrap::pre_shared_key) {
    auto* const keys = own_.pre_shared_keys();
    if (keys == nullptr) return fail(Code::not_protected);
    return keys->encode(plain, out);
  }
  if (receiver.is_zero())
    return transform().encode_rtps_message(own_.crypto(), all_remotes_, plain, out);
  const auto remote = remotes_.find(receiver);
  if (remote == remotes_.end()) return fail(Code::crypto_not_matched);
  return transform().encode_rtps_message(own_.crypto(), std::span(&remote->second.crypto, 1), plain,
                                         out);
}

}  // namespace ddssec::rtps
