// Protected payloads, submessages and messages, also under a pre-shared key, with any octets or
// with changes to genuine ones. Only what was sealed opens, and the genuine one opens after every
// attack.
#include <cstdlib>

#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::cryptography::testing;

struct Target {
  // This is under another IV each time, because with origin authentication each message counts
  // once.
  std::function<Bytes()> seal;
  Bytes opened;
  std::function<Result<Bytes>(const Bytes&)> open;
};

// A matched pair with one kind of protection, and one genuine message of each level.
struct Pair {
  explicit Pair(ProtectionKind kind)
      : two(kind),
        ends(two.endpoints(endpoint_attributes(
            kind, is_encrypted(kind) ? ProtectionKind::encrypt : ProtectionKind::sign))) {
    add([this] { return encode_payload(two, ends, Bytes(22, 3)).value(); },
        [this](const Bytes& in) { return decode_payload(two, ends, in); });
    add([this] { return encode_submessage(two, ends, data_submessage(24)).value(); },
        [this](const Bytes& in) { return decode_submessage(two, ends, in); });
    add([this] { return encode_reply(two, ends, data_submessage(24, 0x06)).value(); },
        [this](const Bytes& in) { return decode_reply(two, ends, in); });
    const auto message = rtps_message({data_submessage(12), data_submessage(8)});
    add([this, message] { return encode_message(two, message).value(); },
        [this](const Bytes& in) { return decode_message(two, in); });
    add(
        [message, keys = pre_shared_keys(two.a, kind)] {
          const auto encode = [&](MutableBytes out) { return keys->encode(message, out); };
          return into_bytes(message.size() + spi::protection_overhead(0), encode).value();
        },
        [keys = pre_shared_keys(two.b, kind)](const Bytes& in) {
          (void)keys->remembers(in);
          return into_bytes(in.size(), [&](MutableBytes out) { return keys->decode(in, out); });
        });
  }
  static std::shared_ptr<spi::PreSharedKeys> pre_shared_keys(Side& side, ProtectionKind kind) {
    ParticipantSecurityAttributes attributes;
    attributes.rtps_psk = is_encrypted(kind) ? ProtectionKind::encrypt : ProtectionKind::sign;
    const PropertyList passphrase = {
        {std::string(spi::property::kPskPassphrase), "data:,1:Sesame"}};
    return side.factory().pre_shared_keys({passphrase, attributes, 0, ""}).value();
  }
  Pair(Pair&&) = delete;
  void add(std::function<Bytes()> seal, std::function<Result<Bytes>(const Bytes&)> open) {
    auto opened = open(seal()).value();
    targets.push_back({std::move(seal), std::move(opened), std::move(open)});
  }

  TwoSides two;
  WriterToReader ends;
  std::vector<Target> targets;
};

void must_not_open(const Target& target, const Bytes& octets) {
  const auto opened = target.open(octets);
  if (opened && *opened != target.opened) std::abort();
}

// Returns `sealed` with `change` applied by exclusive or, cut or extended to `size`.
Bytes changed(Bytes sealed, BytesView change, std::size_t size) {
  sealed.resize(std::max(sealed.size(), change.size()));
  for (std::size_t i = 0; i < change.size(); ++i) sealed[i] ^= change[i];
  sealed.resize(size);
  return sealed;
}

}  // namespace

// Octet 0 chooses the kind and the level, and octet 1 the length of the changed message.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using enum ProtectionKind;
  static std::array<Pair, 4> pairs = {Pair(sign), Pair(encrypt),
                                      Pair(sign_with_origin_authentication),
                                      Pair(encrypt_with_origin_authentication)};
  if (size < 2) return 0;
  auto& pair = pairs[data[0] % 4];
  const auto& target = pair.targets[data[0] / 4 % 5];
  const BytesView rest(data + 2, size - 2);
  must_not_open(target, to_bytes(rest));
  const auto sealed = target.seal();
  const auto length = data[1] == 0 ? sealed.size() : std::size_t{data[1]} * 2;
  must_not_open(target, changed(sealed, rest, length));
  (void)pair.two.b.transform().preprocess_secure_submessage(pair.two.b.participant,
                                                            pair.two.b.remote, rest);
  if (target.open(target.seal()) != target.opened) std::abort();
  return 0;
}
