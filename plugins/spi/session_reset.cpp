#include "plugins/spi/session_reset.hpp"

#include <algorithm>

#include "base/hash.hpp"
#include "base/writer.hpp"

namespace ddssec::spi {
namespace {

// A value from the vendor-specific range of DDS-Security that no cipher uses.
constexpr TransformKind kResetKind{{0xdd, 0x5e, 0xc0, 0xd5}};
constexpr std::size_t kRtpsHeaderSize = 20;
constexpr std::size_t kKindAt = kRtpsHeaderSize + 4;
constexpr std::uint16_t kCryptoHeaderSize = 20;
constexpr std::uint16_t kFooterSize = 20;
constexpr std::uint8_t kSrtpsPrefix = 0x33, kSrtpsPostfix = 0x34, kSecBody = 0x30;
constexpr std::size_t kNameSize = std::tuple_size_v<ResetName>;
constexpr std::uint16_t kTokenSize = kNameSize + ResetProof::capacity;
constexpr std::size_t kTokenAt = kKindAt + kCryptoHeaderSize + 4;
constexpr std::size_t kResetSize = kTokenAt + kTokenSize + 4 + kFooterSize;

void write_submessage_header(Writer& writer, std::uint8_t id, std::uint16_t length) {
  writer.write(id);
  writer.write(std::uint8_t{0});  // for big endian
  writer.write(length);
}

}  // namespace

ResetToken derive_reset_token(const SharedSecret& shared, const GuidPrefix& sender) {
  const auto derive = [&](std::string_view label) {
    return shared.secret.expose([&](BytesView key) {
      return hmac_sha256(key,
                         {as_bytes(label), shared.challenge1, shared.challenge2, sender.view()});
    });
  };
  ResetToken token;
  const auto name = derive("ddssec session reset name");
  std::copy_n(name.begin(), kNameSize, token.name.begin());
  auto proof = derive("ddssec session reset proof");
  token.proof = *ResetProof::copy_of(proof);
  wipe(proof);
  return token;
}

Bytes write_reset(const GuidPrefix& sender, const ResetToken& token) {
  Writer writer(Endian::big, kResetSize);
  writer.write_bytes(as_bytes("RTPS"));
  writer.write_bytes(std::array<std::uint8_t, 4>{2, 5, 0, 0});  // version, unknown vendor
  writer.write_bytes(sender.view());
  write_submessage_header(writer, kSrtpsPrefix, kCryptoHeaderSize);
  writer.write_bytes(kResetKind.view());
  writer.write_bytes(std::array<std::uint8_t, kCryptoHeaderSize - 4>{});
  write_submessage_header(writer, kSecBody, kTokenSize);
  writer.write_bytes(token.name);
  token.proof.expose([&](BytesView proof) { writer.write_bytes(proof); });
  write_submessage_header(writer, kSrtpsPostfix, kFooterSize);
  writer.write_bytes(std::array<std::uint8_t, kFooterSize>{});
  return writer.take();
}

std::optional<Reset> read_reset(BytesView message) {
  if (message.size() != kResetSize) return std::nullopt;
  if (!std::ranges::equal(message.subspan(kKindAt, 4), kResetKind.view())) return std::nullopt;
  const auto token = message.subspan(kTokenAt, kTokenSize);
  return Reset{token.first(kNameSize), token.subspan(kNameSize)};
}

}  // namespace ddssec::spi
