// The cost of one transformation, beside that of the raw AEAD which it needs in any case.
#include <cstdlib>

#include <benchmark/benchmark.h>

#include "plugins/cryptography/aead.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;

// The argument range(1) is the number of bits of AES, or 20 for ChaCha20-Poly1305.
constexpr int kChaCha = 20;
PropertyList bits(benchmark::State& state) {
  if (state.range(1) == kChaCha) return cipher(spi::kChaCha20Poly1305Name, true);
  return key_size(state.range(1) == 128 ? "128" : "256");
}

// The lower bound is one seal, and one allocation and release of the output.
void raw_seal(benchmark::State& state, bool encrypts) {
  ExpandedKey key;
  const auto with = state.range(1) == kChaCha ? Cipher::chacha20_poly1305
                    : state.range(1) == 128   ? Cipher::aes128_gcm
                                              : Cipher::aes256_gcm;
  if (!key.expand(*aead_backend(AeadChoice::automatic), with, Bytes(key_size_of(with), 1)))
    std::abort();
  const auto size = static_cast<std::size_t>(state.range(0));
  const Bytes plain(size, 7);
  Bytes tag(kTagSize);
  Iv iv{};
  for (auto _ : state) {
    auto* const out = static_cast<std::uint8_t*>(std::malloc(size + 64));
    ++iv[11];
    const TagOut where(tag.data(), kTagSize);
    const bool done = encrypts ? key.seal({iv, {}, plain, out, where}) : key.mac(iv, plain, where);
    benchmark::DoNotOptimize(done);
    std::free(out);
  }
}
void raw_gcm(benchmark::State& state) { raw_seal(state, true); }
void raw_gmac(benchmark::State& state) { raw_seal(state, false); }

void payload_encode(benchmark::State& state, ProtectionKind kind) {
  TwoSides two(kNone, bits(state));
  const auto e = two.endpoints(endpoint_attributes(kNone, kind));
  const Bytes plain(static_cast<std::size_t>(state.range(0)), 7);
  Bytes out(plain.size() + 64);
  auto& transform = two.a.transform();
  for (auto _ : state)
    benchmark::DoNotOptimize(transform.encode_serialized_payload(e.writer, plain, out));
}
void payload_decode(benchmark::State& state, ProtectionKind kind) {
  TwoSides two(kNone, bits(state));
  const auto e = two.endpoints(endpoint_attributes(kNone, kind));
  const auto encoded =
      encode_payload(two, e, Bytes(static_cast<std::size_t>(state.range(0)), 7)).value();
  Bytes out(encoded.size());
  auto& transform = two.b.transform();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        transform.decode_serialized_payload(e.reader, e.remote_writer, encoded, out));
}

void submessage_encode(benchmark::State& state, ProtectionKind kind) {
  TwoSides two(kNone, bits(state));
  const auto e = two.endpoints(endpoint_attributes(kind, kNone));
  const auto plain = data_submessage(static_cast<std::size_t>(state.range(0)));
  Bytes out(plain.size() + 200);
  auto& transform = two.a.transform();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        transform.encode_datawriter_submessage(e.writer, {&e.remote_reader, 1}, plain, out));
}
void submessage_decode(benchmark::State& state, ProtectionKind kind) {
  TwoSides two(kNone, bits(state));
  const auto e = two.endpoints(endpoint_attributes(kind, kNone));
  const auto encoded =
      encode_submessage(two, e, data_submessage(static_cast<std::size_t>(state.range(0)))).value();
  Bytes out(encoded.size());
  auto& transform = two.b.transform();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        transform.decode_datawriter_submessage(e.reader, e.remote_writer, encoded, out));
}

void message_encode(benchmark::State& state, ProtectionKind kind) {
  TwoSides two(kind, bits(state));
  const auto plain = rtps_message({data_submessage(static_cast<std::size_t>(state.range(0)))});
  Bytes out(plain.size() + 200);
  auto& transform = two.a.transform();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        transform.encode_rtps_message(two.a.participant, {&two.a.remote, 1}, plain, out));
}
void message_decode(benchmark::State& state, ProtectionKind kind) {
  TwoSides two(kind, bits(state));
  const auto encoded =
      encode_message(two, rtps_message({data_submessage(static_cast<std::size_t>(state.range(0)))}))
          .value();
  Bytes out(encoded.size());
  auto& transform = two.b.transform();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        transform.decode_rtps_message(two.b.participant, two.b.remote, encoded, out));
}

// There is a new session for every message, the worst case for a receiver.
void payload_decode_new_session(benchmark::State& state) {
  TwoSides two(kNone, {}, {.max_blocks_per_session = 1});
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  std::vector<Bytes> encoded;
  for (int i = 0; i < 64; ++i) encoded.push_back(encode_payload(two, e, Bytes(64, 7)).value());
  Bytes out(200);
  std::size_t next = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(two.b.transform().decode_serialized_payload(
        e.reader, e.remote_writer, encoded[next++ % encoded.size()], out));
}

// One small submessage for range(0) receivers.
void origin_authentication(benchmark::State& state) {
  TwoSides two;
  const auto attributes =
      endpoint_attributes(ProtectionKind::encrypt_with_origin_authentication, kNone);
  const auto writer = two.a.factory().register_local_datawriter(two.a.participant, {}, attributes);
  std::vector<DatareaderCryptoHandle> receivers;
  for (int i = 0; i < state.range(0); ++i)
    receivers.push_back(
        two.a.factory()
            .register_matched_remote_datareader(*writer, two.a.remote, shared_secret(), false)
            .value());
  const auto plain = data_submessage(252);
  Bytes out(plain.size() + spi::protection_overhead(receivers.size()));
  for (auto _ : state)
    benchmark::DoNotOptimize(
        two.a.transform().encode_datawriter_submessage(*writer, receivers, plain, out));
}

// Matches the (range(0) + 1)-th remote participant.
void register_remote(benchmark::State& state) {
  Side side;
  const auto local =
      side.factory().register_local_participant({}, {}, {}, participant_attributes(kEncrypt));
  std::int64_t identity = 0;
  for (; identity < state.range(0);)
    (void)side.factory().register_matched_remote_participant(*local, {++identity}, {},
                                                             shared_secret());
  for (auto _ : state) {
    const auto remote = side.factory().register_matched_remote_participant(*local, {++identity}, {},
                                                                           shared_secret());
    state.PauseTiming();
    (void)side.factory().unregister_participant(*remote);
    state.ResumeTiming();
  }
}

struct Shared {
  TwoSides two;
  std::vector<WriterToReader> endpoints;
  Shared() {
    for (int i = 0; i < 2; ++i)
      endpoints.push_back(two.endpoints(endpoint_attributes(kNone, kEncrypt)));
  }
};
Shared& shared() {
  static Shared instance;
  return instance;
}

// Threads that share one writer (range(0) = 0), or have one each (1).
void threads_encode(benchmark::State& state) {
  auto& all = shared();
  const auto writer =
      all.endpoints[state.range(0) == 0 ? 0 : static_cast<std::size_t>(state.thread_index() % 2)]
          .writer;
  const Bytes plain(1024, 7);
  Bytes out(plain.size() + 64);
  for (auto _ : state)
    benchmark::DoNotOptimize(all.two.a.transform().encode_serialized_payload(writer, plain, out));
  state.SetItemsProcessed(state.iterations());
}
void threads_decode(benchmark::State& state) {
  auto& all = shared();
  const auto& e = all.endpoints[0];
  const auto encoded = encode_payload(all.two, e, Bytes(1024, 7)).value();
  Bytes out(encoded.size());
  for (auto _ : state)
    benchmark::DoNotOptimize(
        all.two.b.transform().decode_serialized_payload(e.reader, e.remote_writer, encoded, out));
  state.SetItemsProcessed(state.iterations());
}

void sizes(::benchmark::internal::Benchmark* one) {
  for (const int size : {64, 256, 1024, 8192, 65000}) one->Args({size, 256});
  one->Args({64, 128});
  for (const int size : {64, 1024, 8192}) one->Args({size, kChaCha});
}

BENCHMARK(raw_gcm)->Apply(sizes);
BENCHMARK(raw_gmac)->Apply(sizes);
BENCHMARK_CAPTURE(payload_encode, encrypt, kEncrypt)->Apply(sizes);
BENCHMARK_CAPTURE(payload_decode, encrypt, kEncrypt)->Apply(sizes);
BENCHMARK_CAPTURE(payload_encode, sign, kSign)->Apply(sizes);
BENCHMARK_CAPTURE(payload_decode, sign, kSign)->Apply(sizes);
BENCHMARK_CAPTURE(submessage_encode, encrypt, kEncrypt)->Apply(sizes);
BENCHMARK_CAPTURE(submessage_decode, encrypt, kEncrypt)->Apply(sizes);
BENCHMARK_CAPTURE(submessage_encode, sign, kSign)->Apply(sizes);
BENCHMARK_CAPTURE(submessage_decode, sign, kSign)->Apply(sizes);
BENCHMARK_CAPTURE(message_encode, encrypt, kEncrypt)->Apply(sizes);
BENCHMARK_CAPTURE(message_decode, encrypt, kEncrypt)->Apply(sizes);
BENCHMARK_CAPTURE(message_encode, sign, kSign)->Apply(sizes);
BENCHMARK_CAPTURE(message_decode, sign, kSign)->Apply(sizes);
BENCHMARK(payload_decode_new_session);
BENCHMARK(origin_authentication)->Arg(1)->Arg(8)->Arg(64);
BENCHMARK(register_remote)->Arg(10)->Arg(4000)->Iterations(2000);
BENCHMARK(threads_encode)->Arg(0)->Arg(1)->Threads(1)->Threads(2)->UseRealTime();
BENCHMARK(threads_decode)->Threads(1)->Threads(2)->UseRealTime();

}  // namespace
}  // namespace ddssec::cryptography::testing

BENCHMARK_MAIN();
