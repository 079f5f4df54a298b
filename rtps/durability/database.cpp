#include "rtps/durability/database.hpp"

#include <cerrno>
#include <filesystem>
#include <sqlite3.h>

#include "base/errno_text.hpp"

namespace ddssec::rtps {
namespace {

// Returns the operating system's last error for the write-ahead log or the file; 0 if there is
// none.
int last_errno(sqlite3* database) {
  int number = 0;
  sqlite3_file* log = nullptr;
  sqlite3_file_control(database, "main", SQLITE_FCNTL_JOURNAL_POINTER, &log);
  if (log != nullptr && log->pMethods != nullptr)
    log->pMethods->xFileControl(log, SQLITE_FCNTL_LAST_ERRNO, &number);
  if (number == 0) sqlite3_file_control(database, "main", SQLITE_FCNTL_LAST_ERRNO, &number);
  return number;
}

// Returns the reason, because SQLite has the same message for a full disk and for the store's own
// limit.
std::string reason(int kind, const std::string& path, sqlite3* database) {
  if (database == nullptr || path.empty()) return {};
  if (const int number = kind == SQLITE_IOERR ? last_errno(database) : 0; number != 0)
    return std::string(": ") + errno_text(number);
  if (kind != SQLITE_FULL) return {};
  constexpr std::uintmax_t kFew = 64 << 10;
  std::error_code unknown;
  const auto space = std::filesystem::space(path, unknown);
  if (!unknown && space.available >= kFew) return ": the store has reached its limit";
  return std::string(": ") + errno_text(ENOSPC);
}

// SQLite's message is shown unchanged: it contains names of files and limits, never samples.
std::unexpected<Error> database_error(int code, const std::string& path, sqlite3* database) {
  const int kind = code & 0xff;
  const bool no_room =
      kind == SQLITE_FULL || kind == SQLITE_IOERR || kind == SQLITE_NOMEM || kind == SQLITE_TOOBIG;
  std::string text = database == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(database);
  text += reason(kind, path, database);
  return fail(no_room ? Code::rtps_store_failed : Code::rtps_store_unusable,
              {.document = path.empty() ? "store in memory" : path, .found = std::move(text)});
}

}  // namespace

void SqlStatement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

// Binding fails only for an index that the statement does not have. The indexes are constant and
// tested.
SqlStatement& SqlStatement::bind(int index, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), index, value);
  return *this;
}

SqlStatement& SqlStatement::bind(int index, std::string_view text) {
  sqlite3_bind_text64(statement_.get(), index, text.data(), text.size(), SQLITE_STATIC,
                      SQLITE_UTF8);
  return *this;
}

SqlStatement& SqlStatement::bind(int index, BytesView octets) {
  static constexpr std::uint8_t kNothing = 0;  // a null pointer would bind NULL
  sqlite3_bind_blob64(statement_.get(), index, octets.empty() ? &kNothing : octets.data(),
                      octets.size(), SQLITE_STATIC);
  return *this;
}

Result<bool> SqlStatement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  auto* database = sqlite3_db_handle(statement_.get());
  auto error = database_error(sqlite3_extended_errcode(database), path_, database);
  reset();
  return error;
}

Status SqlStatement::run() {
  DDSSEC_RETURN_IF_ERROR(step());
  reset();
  return {};
}

void SqlStatement::reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
}

std::int64_t SqlStatement::number(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string SqlStatement::text(int column) const {
  const auto view = as_text(octets(column));
  return std::string(view);
}

BytesView SqlStatement::octets(int column) const {
  const auto* begin =
      static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = sqlite3_column_bytes(statement_.get(), column);
  return begin == nullptr ? BytesView{} : BytesView(begin, static_cast<std::size_t>(size));
}

void Database::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Result<Database> Database::open(const std::string& path) {
  sqlite3* raw = nullptr;
  constexpr int kFlags =
      SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_NOFOLLOW | SQLITE_OPEN_EXRESCODE;
  const int code = path.empty()
                       ? sqlite3_open_v2(":memory:", &raw, kFlags | SQLITE_OPEN_MEMORY, nullptr)
                       : sqlite3_open_v2(path.c_str(), &raw, kFlags, nullptr);
  Database out(raw, path);
  if (code != SQLITE_OK)
    return fail(Code::rtps_store_unusable, {.document = path, .found = sqlite3_errstr(code)});
  return out;
}

Result<SqlStatement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* raw = nullptr;
  const int code = sqlite3_prepare_v3(database_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &raw, nullptr);
  SqlStatement out;
  out.statement_.reset(raw);
  out.path_ = path_;
  if (code != SQLITE_OK) return database_error(code, path_, database_.get());
  return out;
}

Status Database::run(std::string_view sql) {
  DDSSEC_ASSIGN_OR_RETURN(auto statement, prepare(sql));
  return statement.run();
}

Result<std::int64_t> Database::number(std::string_view sql) {
  DDSSEC_ASSIGN_OR_RETURN(auto statement, prepare(sql));
  DDSSEC_ASSIGN_OR_RETURN(const auto has_row, statement.step());
  if (!has_row)
    return fail(Code::rtps_store_unusable, {.document = path_, .expected = "a value of its own"});
  return statement.number(0);
}

std::int64_t Database::last_row() const { return sqlite3_last_insert_rowid(database_.get()); }

std::int64_t Database::changes() const { return sqlite3_changes64(database_.get()); }

Result<Database::Transaction> Database::Transaction::begin(Database& database) {
  DDSSEC_RETURN_IF_ERROR(database.run("BEGIN IMMEDIATE"));
  return Transaction(database);
}

Status Database::Transaction::commit() {
  DDSSEC_RETURN_IF_ERROR(database_->run("COMMIT"));
  database_ = nullptr;
  return {};
}

// Some errors have already rolled back. This statement then fails without harm.
Database::Transaction::~Transaction() {
  if (database_ != nullptr) static_cast<void>(database_->run("ROLLBACK"));
}

}  // namespace ddssec::rtps
