#include "rtps/durability/sample_row.hpp"

#include <algorithm>

#include "base/hash.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::size_t kMaxPayload = 64u << 20;
// The limit for an expiry, which is the sum of a time and a duration. Seconds take 32 bits.
constexpr std::int64_t kMaxNanoseconds = (std::int64_t{1} << 32) * 1'000'000'000;

}  // namespace

std::optional<GuidPrefix> identity_from(BytesView octets) {
  if (octets.size() != GuidPrefix{}.octets.size()) return std::nullopt;
  return GuidPrefix::from(octets);
}

SampleSum sum_of(std::int64_t row, StreamId stream, const Change& change,
                 const std::optional<StoredExpiry>& expiry) {
  const auto key = change.key_hash.value_or(KeyHash{});
  const auto time = change.source_time.value_or(Time{});
  const auto origin = change.origin();
  Bytes head(key.begin(), key.end());
  std::ranges::copy(origin.writer.octets(), std::back_inserter(head));
  std::vector<std::int64_t> numbers{row, stream.value, time.seconds, time.fraction,
                                    origin.number.value};
  if (expiry) numbers.insert(numbers.end(), {expiry->at, expiry->lifespan});
  for (const auto number : numbers)
    for (int shift = 0; shift < 64; shift += 8)
      head.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(number) >> shift));
  head.push_back(
      static_cast<std::uint8_t>((change.key_hash ? 1 : 0) | (change.status.disposed ? 2 : 0)));
  const auto digest = sha256({head, change.payload.view()});
  SampleSum out{};
  std::ranges::copy_n(digest.begin(), out.size(), out.begin());
  return out;
}

std::optional<SampleRow> read_row(const SqlStatement& row) {
  SampleRow out;
  auto& change = out.change;
  const auto key = row.octets(1), payload = row.octets(6), writer = row.octets(8);
  if (key.size() != KeyHash{}.size() || payload.size() > kMaxPayload ||
      writer.size() != Guid{}.octets().size())
    return std::nullopt;
  if (row.number(2) != 0) std::ranges::copy(key, change.key_hash.emplace().begin());
  change.status.disposed = row.number(3) != 0;
  change.is_key_only = change.status.disposed;
  change.source_time =
      Time{{static_cast<std::int32_t>(row.number(4)), static_cast<std::uint32_t>(row.number(5))}};
  change.original = {{GuidPrefix::from(writer.first(12)), EntityId::from(writer.subspan(12))},
                     {row.number(9)}};
  change.payload = Payload::copy_of(payload);
  out.identity = identity_from(row.octets(10));
  const StoredExpiry expiry{.at = row.number(11), .lifespan = row.number(12)};
  if (expiry != StoredExpiry{}) {
    if (expiry.lifespan <= 0 || expiry.lifespan > kMaxNanoseconds || expiry.at < -kMaxNanoseconds ||
        expiry.at > kMaxNanoseconds)
      return std::nullopt;
    out.expiry = expiry;
  }
  const auto sum = sum_of(row.number(0), {row.number(13)}, change, out.expiry);
  if (!std::ranges::equal(sum, row.octets(7))) return std::nullopt;
  return out;
}

}  // namespace ddssec::rtps
