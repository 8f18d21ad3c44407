#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <sqlite3.h>

#include "codec/error.h"
#include "codec/stop_flag.h"

namespace tintree::cache {

/// The one adapter to SQLite: a connection and its prepared statements, with failures as Error.
/// Not thread-safe.
class SqliteDb {
 public:
  /// kRead shares an existing file with other readers; kOwn writes to it and from the first use on lets no other
  /// program in, and kCreate makes it first.
  enum class Access { kRead, kOwn, kCreate };
  static Expected<SqliteDb> open(const std::string& path, Access access);

  const std::string& path() const { return path_; }
  Expected<void> exec(const char* sql);
  /// Whether the last call failed because another program holds the file.
  bool is_busy() const { return (sqlite3_errcode(handle_.get()) & 0xff) == SQLITE_BUSY; }
  /// Whether it failed because the file is no database.
  bool is_no_database() const { return (sqlite3_errcode(handle_.get()) & 0xff) == SQLITE_NOTADB; }
  /// From now on calls fail with kStopped once `stop` is set, even in the middle; null: never.
  void set_stop(const StopFlag* stop);
  /// What the last call failed of, as an Error: kIo for the disk, kBadData for a damaged file.
  Error last_error() const;

  /// A prepared statement; reset it before it runs again.
  class Statement {
   public:
    void bind(int at, std::int64_t value) { sqlite3_bind_int64(handle_.get(), at, value); }
    void bind(int at, double value) { sqlite3_bind_double(handle_.get(), at, value); }
    /// The bytes must outlive the next step.
    void bind(int at, std::span<const std::byte> bytes) {
      sqlite3_bind_blob64(handle_.get(), at, bytes.data(), bytes.size(), SQLITE_STATIC);
    }
    void bind(int at, const std::string& text) {
      sqlite3_bind_text(handle_.get(), at, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
    }
    /// True for a row, false at the end.
    Expected<bool> step();
    void reset() { sqlite3_reset(handle_.get()); }
    std::int64_t integer(int column) const { return sqlite3_column_int64(handle_.get(), column); }
    double real(int column) const { return sqlite3_column_double(handle_.get(), column); }
    /// Valid until the next step or reset.
    std::span<const std::byte> blob(int column) const;

   private:
    friend class SqliteDb;
    struct Closer {
      void operator()(sqlite3_stmt* s) const { sqlite3_finalize(s); }
    };
    const SqliteDb* db_ = nullptr;
    std::unique_ptr<sqlite3_stmt, Closer> handle_;
  };

  /// The statement must not outlive this object, nor this object be moved meanwhile.
  Expected<Statement> prepare(const char* sql) const;
  /// The first column of a query's only row.
  Expected<std::int64_t> query_integer(const char* sql) const;
  /// The first column of all its rows.
  Expected<std::vector<std::int64_t>> query_integers(const char* sql) const;

 private:
  struct Closer {
    void operator()(sqlite3* db) const { sqlite3_close(db); }
  };
  std::string path_;
  std::unique_ptr<sqlite3, Closer> handle_;
};

}  // namespace tintree::cache
