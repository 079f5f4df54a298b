// Every allocation of a participant's life through the C ABI fails once, and once together with all
// later ones. The call is refused, leaks nothing, and succeeds when it is repeated. This is a
// program of its own because it replaces malloc and operator new.
#include <atomic>
#include <cstdlib>
#include <dlfcn.h>
#include <optional>
#include <string>
#include <tuple>

#include <gtest/gtest.h>
#include <openssl/crypto.h>

#include "tests/unit/cyclonedds/whole_life.hpp"

namespace ddssec::driver {
namespace {

// The blocks of OpenSSL among memory::live_blocks(). OpenSSL allocates through these functions.
std::atomic<long> live_in_openssl = 0;

void* openssl_malloc(std::size_t size, const char*, int) {
  void* const block = std::malloc(size);
  if (block != nullptr) ++live_in_openssl;
  return block;
}
void openssl_free(void* block, const char*, int) {
  if (block != nullptr) --live_in_openssl;
  std::free(block);
}
void* openssl_realloc(void* block, std::size_t size, const char* file, int line) {
  if (size == 0) {
    openssl_free(block, file, line);
    return nullptr;
  }
  void* const moved = std::realloc(block, size);
  if (block == nullptr && moved != nullptr) ++live_in_openssl;
  return moved;
}
// This is possible only before OpenSSL's first allocation.
const bool is_counting_openssl =
    CRYPTO_set_mem_functions(openssl_malloc, openssl_realloc, openssl_free) == 1;

// Blocks that are still allocated after a life.
struct Leftovers {
  long ours;
  long in_openssl;
};

// Returns the blocks that a life leaves behind. The blocks of OpenSSL's state for this thread do
// not count.
Leftovers left_by_a_life(std::optional<Plan> plan) {
  const long before = memory::live_blocks(), in_openssl_before = live_in_openssl;
  {
    const Life life(plan);
    EXPECT_EQ(life.failed() > 500, plan.has_value()) << life.failed();
  }
  OPENSSL_thread_stop();
  const long in_openssl = live_in_openssl - in_openssl_before;
  // A sanitized build counts operator new only.
  const long all = memory::live_blocks() - before;
  return {.ours = memory::counts_malloc() ? all - in_openssl : all, .in_openssl = in_openssl};
}

// How many blocks OpenSSL itself may lose in a life of more than 500 calls that fail. Up
// to 3.0.19, CMS_verify loses a BIO of 5 blocks when it cannot start, and a life verifies 6
// documents. One certificate or key that our code lost would have more blocks.
constexpr long kMaxLostByOpenssl = 30;

class FailingMemory : public testing::TestWithParam<std::tuple<Source, Extent>> {};

TEST_P(FailingMemory, EachFailure_IsToldLeaksNothingAndTheNextCallWorks) {
  const auto [source, extent] = GetParam();
  const Domain stays_loaded(kPaths);
  // OpenSSL keeps what it makes at the first need, also on the way of a failure.
  left_by_a_life({});
  left_by_a_life(Plan{source, extent});
  const auto [ours, in_openssl] = left_by_a_life({});
  EXPECT_EQ(ours, 0);
  EXPECT_EQ(in_openssl, 0);
  const auto [ours_failing, in_openssl_failing] = left_by_a_life(Plan{source, extent});
  EXPECT_EQ(ours_failing, 0);
  EXPECT_GE(in_openssl_failing, 0);
  EXPECT_LE(in_openssl_failing, source == Source::c ? kMaxLostByOpenssl : 0);
}

TEST(FailingMemoryOfOpenssl, EachAllocation_IsCounted) {
  ASSERT_TRUE(is_counting_openssl);
  const long before = live_in_openssl;
  void* const block = OPENSSL_malloc(1);
  EXPECT_EQ(live_in_openssl, before + 1);
  OPENSSL_free(block);
  EXPECT_EQ(live_in_openssl, before);
}

std::string plan_name(const testing::TestParamInfo<FailingMemory::ParamType>& info) {
  const auto [source, extent] = info.param;
  return std::string(source == Source::cpp ? "New" : "Malloc") +
         (extent == Extent::once ? "Once" : "FromThenOn");
}
INSTANTIATE_TEST_SUITE_P(Plans, FailingMemory,
                         testing::Combine(testing::ValuesIn(memory::sources()),
                                          testing::Values(Extent::once, Extent::from_then_on)),
                         plan_name);

// The host's entry points report a failure by their result only.
TEST(FailingMemoryAtInit, EachFailure_IsTold) {
  const Domain stays_loaded(kPaths);
  for (const auto& [path, entry] : {std::pair(kPaths.authentication, "authentication"),
                                    std::pair(kPaths.access_control, "access_control"),
                                    std::pair(kPaths.cryptography, "crypto")}) {
    void* const library = dlopen(path.c_str(), RTLD_NOW);
    const auto init = reinterpret_cast<int (*)(const char*, void**, ddsi_domaingv*)>(
        dlsym(library, (std::string("init_") + entry).c_str()));
    const auto finalize = reinterpret_cast<int (*)(void*)>(
        dlsym(library, (std::string("finalize_") + entry).c_str()));
    bool done = false;
    void* warm = nullptr;
    ASSERT_EQ(init("", &warm, nullptr), 0);
    finalize(warm);
    const auto before = memory::live_blocks();
    for (long number = 1; !done; ++number) {
      void* context = nullptr;
      memory::fail_at(Source::cpp, Extent::once, number);
      const int result = init("", &context, nullptr);
      done = !memory::stop_failing();
      EXPECT_EQ(result == 0, done) << entry << number;
      EXPECT_EQ(context != nullptr, done);
      if (context != nullptr) finalize(context);
      ASSERT_LT(number, 1000);
    }
    EXPECT_EQ(memory::live_blocks(), before) << entry;
    dlclose(library);
  }
}

}  // namespace
}  // namespace ddssec::driver
