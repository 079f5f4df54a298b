// The parts of SQLite that the sample store needs: handles that close themselves, and errors as
// return values.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "base/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace ddssec::rtps {

/// A prepared statement. Bound texts and octets are borrowed until the next reset.
class SqlStatement {
 public:
  SqlStatement() = default;
  SqlStatement& bind(int index, std::int64_t value);
  SqlStatement& bind(int index, std::string_view text);
  SqlStatement& bind(int index, BytesView octets);
  /// Returns true if there is a row.
  Result<bool> step();
  /// Runs a statement without rows, and resets it.
  Status run();
  void reset();

  std::int64_t number(int column) const;
  std::string text(int column) const;
  /// Returns the octets of a column. They are valid until the next step.
  BytesView octets(int column) const;

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  std::string path_;
};

/// One connection, for one thread at a time.
class Database {
 public:
  /// Opens a database; an empty path means one in memory. The file must exist; symbolic links are
  /// not followed. Errors: rtps_store_unusable.
  static Result<Database> open(const std::string& path);

  /// Prepares a statement. Errors: rtps_store_failed (no room), rtps_store_unusable (anything
  /// else).
  Result<SqlStatement> prepare(std::string_view sql);
  /// Runs one statement whose rows are not needed. Errors: those of prepare.
  Status run(std::string_view sql);
  /// Returns the first column of the first row. Errors: those of prepare, rtps_store_unusable (no
  /// row).
  Result<std::int64_t> number(std::string_view sql);
  std::int64_t last_row() const;
  /// Returns the number of rows that the last statement changed.
  std::int64_t changes() const;

  /// A transaction, which the destructor rolls back unless it was committed.
  class Transaction {
   public:
    static Result<Transaction> begin(Database& database);
    Transaction(Transaction&& other) noexcept
        : database_(std::exchange(other.database_, nullptr)) {}
    Transaction& operator=(Transaction&&) = delete;
    ~Transaction();
    Status commit();

   private:
    explicit Transaction(Database& database) : database_(&database) {}
    Database* database_;
  };

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  Database(sqlite3* database, std::string path) : database_(database), path_(std::move(path)) {}

  std::unique_ptr<sqlite3, Close> database_;
  std::string path_;
};

}  // namespace ddssec::rtps
