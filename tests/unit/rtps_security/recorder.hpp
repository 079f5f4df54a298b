// An attacker that took part once and kept everything: each key that its plugin ever got, and a
// copy of everything that is sent. It tries every key on everything.
#pragma once

#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/key_material.hpp"
#include "plugins/cryptography/receive_key.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"

namespace ddssec::rtps::testing {

/// Reads everything that is sent, with all keys that a KeyThief got. It cannot look into what it
/// cannot open.
class Recorder {
 public:
  struct Level {
    int seen = 0;    ///< how many were protected with a key whose id it knows
    int opened = 0;  ///< how many of these it opened, or verified if only signed
    bool operator==(const Level&) const = default;
  };
  Level messages, groups, payloads;
  int seen() const { return messages.seen + groups.seen + payloads.seen; }
  int opened() const { return messages.opened + groups.opened + payloads.opened; }
  void forget() { messages = groups = payloads = {}; }

  explicit Recorder(const KeyThief::Stolen& stolen) {
    for (const auto& token : stolen.all)
      if (auto material = cryptography::read_crypto_token(token); material && !material->is_none())
        materials_.push_back(std::move(*material));
  }

  void read(BytesView datagram) {
    using namespace cryptography;
    if (datagram.size() <= kRtpsHeaderSize) return;
    const auto body = datagram.subspan(kRtpsHeaderSize);
    if (body[0] != submessage_id::kSrtpsPrefix) return walk(body);
    if (const auto whole = read_protected_group(body, kMessageFrame))
      if (const auto plain = opened(*whole, messages)) walk(*plain);
  }

 private:
  static std::size_t whole_size(BytesView octets) {
    const auto header = cryptography::read_submessage_header(octets);
    const bool to_the_end = header.length == 0 && header.id != 0x09 && header.id != 0x01;
    return to_the_end ? octets.size() : std::min(octets.size(), 4 + header.length);
  }

  void walk(BytesView octets) {
    using namespace cryptography;
    while (octets.size() >= 4) {
      auto size = whole_size(octets);
      if (octets[0] == submessage_id::kSecPrefix) {
        for (int part = 0; part < 2 && octets.size() - size >= 4; ++part)
          size += whole_size(octets.subspan(size));
        if (const auto group = read_protected_group(octets.first(size), kSubmessageFrame))
          if (const auto plain = opened(*group, groups)) read_payload(*plain);
      } else {
        read_payload(octets.first(size));
      }
      octets = octets.subspan(size);
    }
  }

  /// Reads a DATA without inline QoS.
  void read_payload(BytesView submessage) {
    using namespace cryptography;
    const bool data = submessage.size() > 24 && submessage[0] == submessage_id::kData;
    if (!data || (submessage[1] & 0x02) != 0) return;
    if (const auto payload = read_protected_payload(submessage.subspan(24)))
      static_cast<void>(opened(*payload, payloads));
  }

  std::optional<Bytes> opened(const cryptography::ProtectedParts& what, Level& level) {
    using namespace cryptography;
    bool known = false;
    for (const auto& material : materials_) {
      const auto traits = *traits_of(material.kind);
      if (material.sender_key_id != what.header.key_id) continue;
      if (!std::exchange(known, true)) ++level.seen;
      ReceiveKey key(material.clone(), traits, services_);
      const ReadGuard guard;
      const auto session = key.session(what.header.session_id);
      Bytes plain(what.content.size());
      const auto& [iv, tag] = std::tie(what.header.iv, what.footer.common_mac);
      const TagView expected(tag.data(), kTagSize);
      const bool good = what.is_encrypted
                            ? (*session)->key.open(iv, {}, what.content, plain.data(), expected)
                            : (*session)->key.verify(iv, what.content, expected);
      if (!good) continue;
      ++level.opened;
      return what.is_encrypted ? plain : to_bytes(what.content);
    }
    return std::nullopt;
  }

  std::vector<cryptography::KeyMaterial> materials_;
  cryptography::RetiredObjects retired_objects_;
  SystemRandom random_;
  cryptography::KeyServices services_{
      *cryptography::aead_backend(cryptography::AeadChoice::automatic), retired_objects_, 1u << 20,
      1u << 20, random_};
};

}  // namespace ddssec::rtps::testing
