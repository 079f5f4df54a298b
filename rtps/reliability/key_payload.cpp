#include "rtps/reliability/key_payload.hpp"

#include "rtps/cdr/encapsulation.hpp"

namespace ddssec::rtps {
namespace {

// What Fast DDS takes for a key hash is at most this long, encapsulation included.
constexpr std::size_t kLongestTakenForHash = 16;

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
  // Readers stop at the key's last member. In XCDR2 the length tells layouts apart and must stay as
  // it is; Fast DDS 2 knows XCDR1 only.
  const bool grows = readers.short_is_hash && opened->encapsulation == Encapsulation::cdr &&
                     payload.size() <= kLongestTakenForHash;
  if (!grows) return payload;
  scratch.assign(payload.begin(), payload.end());
  scratch[3] = static_cast<std::uint8_t>(scratch[3] & ~3u);  // the padding is counted no more
  scratch.resize(kLongestTakenForHash + 4);
  return scratch;
}

}  // namespace ddssec::rtps
