#include "rtps/durability/sample_row.hpp"

#include <gtest/gtest.h>

#include "tests/support/expect_code.hpp"
#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

constexpr StreamId kStream{3};
constexpr std::int64_t kRow = 7;
constexpr StoredExpiry kExpiry{.at = 5'000, .lifespan = 1'000};
const GuidPrefix kIdentity = GuidPrefix::from(Bytes(12, 0x1d));

Change stored_change() {
  auto change = testing::sample(9);
  change.original = {{GuidPrefix::from(Bytes(12, 0x0a)), EntityId::from(Bytes(4, 0x02))}, {41}};
  return change;
}

// A table with the columns that rows are read from.
struct SampleRowTest : ::testing::Test {
  SampleRowTest() {
    run("CREATE TABLE sample (id, key, keyed, disposed, seconds, fraction, payload, sum, writer, "
        "number, identity, expires, lifespan, stream)");
    store(stored_change(), kExpiry);
  }
  void run(const std::string& sql) { ASSERT_OK(database.run(sql)); }
  void store(const Change& change, const std::optional<StoredExpiry>& expiry) {
    run("DELETE FROM sample");
    const auto sum = sum_of(kRow, kStream, change, expiry);
    const auto key = change.key_hash.value_or(KeyHash{});
    const auto writer = change.origin().writer.octets();
    auto insert = *database.prepare("INSERT INTO sample VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
    insert.bind(1, kRow).bind(2, BytesView(key));
    insert.bind(3, std::int64_t{change.key_hash.has_value()});
    insert.bind(4, std::int64_t{change.status.disposed});
    insert.bind(5, std::int64_t{change.source_time->seconds});
    insert.bind(6, std::int64_t{change.source_time->fraction});
    insert.bind(7, change.payload.view()).bind(8, BytesView(sum)).bind(9, BytesView(writer));
    insert.bind(10, change.origin().number.value).bind(11, BytesView(kIdentity.octets));
    insert.bind(12, expiry ? expiry->at : 0).bind(13, expiry ? expiry->lifespan : 0);
    insert.bind(14, kStream.value);
    ASSERT_OK(insert.run());
  }
  std::optional<SampleRow> read() {
    auto rows = *database.prepare(kSelectSamples);
    if (!*rows.step()) return std::nullopt;
    return read_row(rows);
  }

  Database database = *Database::open("");
};

TEST_F(SampleRowTest, Stored_IsReadAsItWas) {
  const auto row = read();
  ASSERT_TRUE(row);
  EXPECT_EQ(testing::number_of(row->change), 9U);
  EXPECT_EQ(row->change.origin(), stored_change().origin());
  EXPECT_FALSE(row->change.status.disposed);
  EXPECT_EQ(row->identity, kIdentity);
  EXPECT_EQ(row->expiry, kExpiry);
}

TEST_F(SampleRowTest, RowWithoutKeyAndExpiry_IsReadWithoutThem) {
  auto change = stored_change();
  change.key_hash.reset();
  store(change, std::nullopt);
  const auto row = read();
  ASSERT_TRUE(row);
  EXPECT_FALSE(row->change.key_hash);
  EXPECT_FALSE(row->expiry);
}

TEST_F(SampleRowTest, Dispose_IsAKeyWithoutASample) {
  auto change = stored_change();
  change.status.disposed = true;
  store(change, kExpiry);
  const auto row = read();
  ASSERT_TRUE(row);
  EXPECT_TRUE(row->change.status.disposed);
  EXPECT_TRUE(row->change.is_key_only);
}

// The sum does not cover the identity alone, because an earlier version stored none.
TEST_F(SampleRowTest, DamagedColumn_IsNotRead) {
  for (const std::string damage :
       {"id = 8", "key = x'00'", "keyed = 0", "disposed = 1", "seconds = seconds + 1",
        "fraction = 1", "payload = x'00'", "sum = x''", "writer = x'0a'", "number = 42",
        "expires = 5001", "lifespan = 999", "lifespan = 0", "lifespan = -1000", "stream = 4"}) {
    store(stored_change(), kExpiry);
    ASSERT_TRUE(read());
    run("UPDATE sample SET " + damage);
    EXPECT_FALSE(read()) << damage;
  }
}

// The calendar time is added to the expiry, so the sum must stay a number.
TEST_F(SampleRowTest, ExpiryOutsideTheClock_IsNotRead) {
  constexpr auto kFar = std::int64_t{1} << 62;
  for (const StoredExpiry expiry :
       {StoredExpiry{.at = kFar, .lifespan = 1}, StoredExpiry{.at = -kFar, .lifespan = 1},
        StoredExpiry{.at = 1, .lifespan = kFar}}) {
    store(stored_change(), expiry);
    EXPECT_FALSE(read()) << expiry.at << ' ' << expiry.lifespan;
  }
}

TEST(IdentityFrom, TwelveOctets_AreAnIdentity) {
  EXPECT_EQ(identity_from(kIdentity.octets), kIdentity);
  EXPECT_EQ(identity_from({}), std::nullopt);
  EXPECT_EQ(identity_from(Bytes(13)), std::nullopt);
}

}  // namespace
}  // namespace ddssec::rtps
