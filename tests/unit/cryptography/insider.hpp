// An insider: it holds a sender's key, as each receiver of that sender does, and builds messages
// that our encoders would not build.
#pragma once

#include <gtest/gtest.h>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/send_key.hpp"

namespace ddssec::cryptography::testing {

struct Insider {
  RetiredObjects retired_objects;
  SystemRandom random;
  KeyServices services{*aead_backend(AeadChoice::automatic), retired_objects, 1u << 20, 1u << 20,
                       random};
  std::unique_ptr<SendKey> key;

  /// Makes an insider with the key of a sender, as one of its receivers has it.
  explicit Insider(KeyMaterial material, SendStart start = {5, 6})
      : own_(material.receiver_key_id, material.clone().receiver_key, services) {
    key = std::move(SendKey::create(std::move(material), start, services).value());
  }
  /// Makes an insider with a key of its own.
  explicit Insider(TransformKind kind) : Insider(material_of(kind)) {}
  spi::Token token() const { return crypto_token(key->material()); }

  /// Returns a group whose tag fits any content. For each of `receivers` it has a MAC by the only
  /// receiver-specific key of an insider: its own.
  Bytes group(Frame frame, const Bytes& content, const std::vector<KeyId>& receivers = {}) {
    const ReadGuard guard;
    const auto reserved = key->reserve(content.size()).value();
    const bool encrypts = key->traits().encrypts;
    const auto macs_size = kReceiverMacSize * receivers.size();
    Bytes out(content.size() + macs_size + 100);
    UncheckedWriter pen(out);
    pen.submessage_header(frame.prefix, 20);
    pen.crypto_header(key->material().kind, key->material().sender_key_id, reserved.iv);
    if (encrypts) {
      pen.submessage_header(0x30, 4 + padded(content.size()));
      pen.u32(static_cast<std::uint32_t>(content.size()));
    }
    auto* const place = pen.skip(content.size());
    if (encrypts) pen.zeros(padded(content.size()) - content.size());
    pen.submessage_header(frame.postfix, 20 + macs_size);
    const TagOut tag(pen.skip(16), 16);
    if (!encrypts) std::ranges::copy(content, place);
    EXPECT_TRUE(encrypts ? reserved.session->key.seal({reserved.iv, {}, content, place, tag})
                         : reserved.session->key.mac(reserved.iv, content, tag));
    pen.u32(static_cast<std::uint32_t>(receivers.size()));
    for (const auto& receiver : receivers) {
      pen.put(receiver.octets);
      EXPECT_TRUE(own_.mac(*key, reserved, tag, TagOut(pen.skip(16), 16)));
    }
    out.resize(pen.written());
    return out;
  }

 private:
  ReceiverKey own_;

  static KeyMaterial material_of(TransformKind kind) {
    const auto size = traits_of(kind)->key_size();
    KeyMaterial material{.kind = kind};
    material.salt = MasterSalt::copy_of(Bytes(size, 1)).value();
    material.sender_key_id = KeyId{{9, 9, 9, 9}};
    material.sender_key = MasterKey::copy_of(Bytes(size, 2)).value();
    return material;
  }
};

}  // namespace ddssec::cryptography::testing
