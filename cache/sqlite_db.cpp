#include "cache/sqlite_db.h"

#include <cerrno>
#include <cstring>
#include <utility>

namespace tintree::cache {

namespace {

int flags_of(SqliteDb::Access access) {
  switch (access) {
    case SqliteDb::Access::kRead:
      return SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_READONLY;
    case SqliteDb::Access::kOwn:
      return SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_READWRITE;
    case SqliteDb::Access::kCreate:
      return SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  }
  return 0;
}

int look_at_stop(void* stop) { return is_set(static_cast<const StopFlag*>(stop)) ? 1 : 0; }

}  // namespace

Expected<SqliteDb> SqliteDb::open(const std::string& path, Access access) {
  SqliteDb db;
  db.path_ = path;
  sqlite3* handle = nullptr;
  const int rc = sqlite3_open_v2(path.c_str(), &handle, flags_of(access), nullptr);
  db.handle_.reset(handle);
  if (rc != SQLITE_OK) return tl::unexpected(db.last_error());
  sqlite3_extended_result_codes(handle, 1);
  if (access != Access::kRead) {
    if (auto done = db.exec("PRAGMA locking_mode = EXCLUSIVE"); !done) return tl::unexpected(done.error());
  }
  return db;
}

void SqliteDb::set_stop(const StopFlag* stop) {
  constexpr int kStepsPerLook = 1000;
  // SQLite hands the flag back as it got it, and look_at_stop() only reads it.
  sqlite3_progress_handler(handle_.get(), stop == nullptr ? 0 : kStepsPerLook, look_at_stop,
                           const_cast<StopFlag*>(stop));
}

Error SqliteDb::last_error() const {
  int code = sqlite3_errcode(handle_.get()) & 0xff;
  const int system = sqlite3_system_errno(handle_.get());
  if (code == SQLITE_IOERR && system == ENOSPC) code = SQLITE_FULL;
  const std::string reason = sqlite3_errmsg(handle_.get());
  switch (code) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
    case SQLITE_ERROR:  // a table or column that has to be there is not
      return {ErrorCode::kBadData, "is damaged or cut short (" + reason + "); build it again or restore a copy", path_};
    case SQLITE_FULL:
      return {ErrorCode::kIo, "the disk is full; free some space and run the same command with --resume", path_};
    case SQLITE_CANTOPEN:
      return {ErrorCode::kIo, "cannot be opened; check that the folder exists and may be written to", path_};
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return {ErrorCode::kIo, "may not be written to; check its permissions", path_};
    case SQLITE_BUSY:
      return {ErrorCode::kIo, "is in use by another program; wait for it or stop it", path_};
    case SQLITE_INTERRUPT:
      return {ErrorCode::kStopped, "stopped", {}};
    case SQLITE_IOERR:
      return {ErrorCode::kIo, "cannot be read or written (" + (system != 0 ? std::strerror(system) : reason) + ")",
              path_};
    default:
      return {ErrorCode::kIo, reason, path_};
  }
}

Expected<void> SqliteDb::exec(const char* sql) {
  if (sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) return tl::unexpected(last_error());
  return {};
}

Expected<bool> SqliteDb::Statement::step() {
  const int rc = sqlite3_step(handle_.get());
  if (rc == SQLITE_ROW) return true;
  if (rc == SQLITE_DONE) return false;
  return tl::unexpected(db_->last_error());
}

std::span<const std::byte> SqliteDb::Statement::blob(int column) const {
  const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(handle_.get(), column));
  return {data, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
}

Expected<SqliteDb::Statement> SqliteDb::prepare(const char* sql) const {
  Statement out;
  out.db_ = this;
  sqlite3_stmt* statement = nullptr;
  const int rc = sqlite3_prepare_v2(handle_.get(), sql, -1, &statement, nullptr);
  out.handle_.reset(statement);
  if (rc != SQLITE_OK) return tl::unexpected(last_error());
  return out;
}

Expected<std::int64_t> SqliteDb::query_integer(const char* sql) const {
  auto statement = prepare(sql);
  if (!statement) return tl::unexpected(statement.error());
  auto row = statement->step();
  if (!row) return tl::unexpected(row.error());
  return *row ? statement->integer(0) : 0;
}

Expected<std::vector<std::int64_t>> SqliteDb::query_integers(const char* sql) const {
  auto statement = prepare(sql);
  if (!statement) return tl::unexpected(statement.error());
  std::vector<std::int64_t> found;
  while (true) {
    auto row = statement->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return found;
    found.push_back(statement->integer(0));
  }
}

}  // namespace tintree::cache
