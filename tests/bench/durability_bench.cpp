// Measures how many small samples a second a store of persistent samples takes.
// Usage: bench_durability FILE [COUNT]     The file is created, and removed at the end.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "rtps/durability/durable_store.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::rtps;

struct Log final : EventSink {
  void raise(const Event& event) override { std::fprintf(stderr, "%s\n", event.to_line().c_str()); }
};

int run(const std::string& path, std::uint32_t count) {
  constexpr std::chrono::hours kLong{1};
  Log log;
  auto store = DurableStore::open(path, log);
  if (!store) return std::fprintf(stderr, "%s\n", store.error().to_sentence().c_str()), 1;
  DurabilityService service;
  service.history = {HistoryKind::keep_all, 1};
  const auto stream = (*store)->open_stream({.topic = "Bench", .type = "Bench"}, service, Moment{});
  if (!stream) return 1;
  Change change;
  change.key_hash.emplace();
  change.source_time = Time{};
  change.payload = Payload::copy_of(Bytes(64, 7));
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((*store)->is_behind() && !(*store)->wait_for_room(kLong)) return 1;
    (*store)->append(stream->id, change, Moment{});
  }
  if (!(*store)->flush(kLong)) return 1;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("%.0f samples/s: %u samples of 64 octets in %.2f s, committed in %llu groups\n",
              count / took.count(), count, took.count(),
              static_cast<unsigned long long>((*store)->groups()));
  std::printf("durability mode: SQLite write-ahead log, synchronous=FULL (fsync at each commit)\n");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: bench_durability FILE [COUNT]\n"), 2;
  const std::string path = argv[1];
  if (std::filesystem::exists(path)) return std::fprintf(stderr, "%s exists\n", argv[1]), 2;
  const int code = run(path, argc > 2 ? static_cast<std::uint32_t>(std::atoi(argv[2])) : 200'000);
  for (const auto* suffix : {"", "-wal"}) std::filesystem::remove(path + suffix);
  return code;
}
