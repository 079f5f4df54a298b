#include "rtps/reliability/key_payload.hpp"

#include "rtps/cdr/encapsulation.hpp"

namespace ddssec::rtps {
namespace {

// The largest payload that Fast DDS interprets as a key hash, including its encapsulation.
constexpr std::size_t kMaxTakenForHash = 16;

}  // namespace

BytesView key_payload_for(const KeyReading& readers, BytesView payload, const KeyRewriter& to_bare,
                          Bytes& scratch) {
  if (readers == KeyReading{}) return payload;
  const auto opened = open_payload(payload);
  if (!opened) return payload;
  const bool xcdr2 = opened->encapsulation == Encapsulation::delimited_cdr2 ||
                     opened->encapsulation == Encapsulation::cdr2;
  if (readers.bare_only && xcdr2 && to_bare) {
    scratch = to_bare(payload);
    return scratch.empty() ? payload : BytesView(scratch);
  }
  // Readers stop after the key's last member, so the payload may become longer. In XCDR2 its length
  // must not change, because the length distinguishes layouts. Fast DDS 2 knows only XCDR1.
  const bool grows = readers.short_is_hash && opened->encapsulation == Encapsulation::cdr &&
                     payload.size() <= kMaxTakenForHash;
  if (!grows) return payload;
  scratch.assign(payload.begin(), payload.end());
  scratch[3] = static_cast<std::uint8_t>(scratch[3] & ~3u);  // the padding is no longer counted
  scratch.resize(kMaxTakenForHash + 4);
  return scratch;
}

}  // namespace ddssec::rtps
