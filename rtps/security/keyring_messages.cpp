// The part of Keyring that protects whole messages with participants' keys.
#include <utility>

#include "plugins/spi/session_reset.hpp"
#include "rtps/security/keyring.hpp"
#include "wire/submessage.hpp"

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
    if (pre_shared_.are_due()) return pre_shared_.missing_protection_error(header, now);
    return OpenMessage{message};
  }
  if (spi::has_pre_shared_key_flag(message)) {
    DDSSEC_ASSIGN_OR_RETURN(auto opened, pre_shared_.open(header, message, scratch, now));
    return OpenMessage{std::move(opened)};
  }
  // The peer has ended the session. With ddssec's plugins in Cyclone DDS it answers every message
  // in this way after a revocation or an expiry. This is not a damaged message.
  if (const auto reset = spi::read_reset(message)) {
    own_.session_ends().note_reset(header.prefix, *reset, now);
    return fail(Code::session_reset_by_peer);
  }
  const auto remote = remotes_.find(header.prefix);
  if (remote == remotes_.end())
    return undecodable_error(Error(Code::crypto_not_matched), header.prefix);
  const auto opened =
      phases_.messages().open(remote->second.crypto, message, scratch, remote->second.says_next);
  if (!opened) return undecodable_error(opened.error(), header.prefix);
  return OpenMessage{scratch.first(opened->size), true, opened->age};
}

Result<std::size_t> Keyring::protect_message(Wrap wrap, const GuidPrefix& receiver, BytesView plain,
                                             MutableBytes out) {
  if (wrap == Wrap::pre_shared_key) return pre_shared_.protect(plain, out);
  if (receiver.is_zero()) return phases_.messages().protect(nullptr, plain, out);
  const auto remote = remotes_.find(receiver);
  if (remote == remotes_.end()) return fail(Code::crypto_not_matched);
  return phases_.messages().protect(&remote->second.crypto, plain, out);
}

}  // namespace ddssec::rtps
