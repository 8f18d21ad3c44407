#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "cache/tile_digest.h"
#include "cache/tile_rows.h"
#include "cache/tile_store.h"

namespace tintree::cache {
namespace {

namespace fs = std::filesystem;

constexpr int kTilesPerTransaction = 256;

Expected<void> sync_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail(ErrorCode::kIo, std::strerror(errno), path);
  const int rc = ::fsync(fd);
  const int reason = errno;
  ::close(fd);
  if (rc != 0) return fail(ErrorCode::kIo, std::strerror(reason), path);
  return {};
}

/// Puts a whole file in the place of another, or of none, so that a crash leaves the one or the other.
Expected<void> move_into_place(const std::string& from, const std::string& to) {
  if (auto synced = sync_file(from); !synced) return synced;
  std::error_code ec;
  fs::rename(from, to, ec);
  if (ec) return fail(ErrorCode::kIo, "cannot be put in place: " + ec.message(), to);
  const std::string folder = fs::path(to).parent_path().string();
  return sync_file(folder.empty() ? "." : folder);
}

/// The file of a build that is being begun, and that of one that is being finished.
std::string new_path(const std::string& building) { return building + "-new"; }
std::string packed_path(const std::string& building) { return building + "-packed"; }

void remove_database(const std::string& path) {
  std::error_code ec;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) fs::remove(path + suffix, ec);
}

void remove_build(const std::string& building) {
  for (const std::string& path : {building, new_path(building), packed_path(building)}) remove_database(path);
}

/// Fails when another program is building there.
Expected<void> check_free(const std::string& building) {
  std::error_code ec;
  if (!fs::is_regular_file(building, ec)) return {};
  auto db = SqliteDb::open(building, SqliteDb::Access::kOwn);
  if (!db) return {};
  auto locked = db->exec("BEGIN EXCLUSIVE");
  return locked || !db->is_busy() ? Expected<void>{} : locked;
}

/// Makes the file of an unfinished tree that holds its manifest and no tile yet.
Expected<void> begin_file(const std::string& path, const Manifest& manifest) {
  auto db = SqliteDb::open(path, SqliteDb::Access::kCreate);
  if (!db) return tl::unexpected(db.error());
  auto done = db->exec("PRAGMA synchronous = OFF");  // it is synced as a whole when it gets its name
  if (done) done = create_tables(*db, manifest);
  if (done) done = write_manifest(*db, manifest);
  // Else closing would do this, and fail unseen.
  return done ? db->exec("PRAGMA wal_checkpoint(TRUNCATE)") : done;
}

}  // namespace

struct TileWriter::Impl {
  std::string goal;
  SqliteDb db;
  Manifest manifest;
  std::optional<SqliteDb::Statement> insert;
  std::map<PictureKind, SqliteDb::Statement> insert_picture;
  int pending = 0;

  Expected<void> prepare() {
    // What is committed survives the death of the process without a sync; a power cut may cost the last tiles.
    if (auto done = db.exec("PRAGMA synchronous = NORMAL"); !done) return done;
    auto statement = db.prepare(kInsertTile);
    if (!statement) return tl::unexpected(statement.error());
    insert.emplace(std::move(*statement));
    for (const PictureKind kind : kPictureKinds) {
      if (manifest.picture_size(kind) == 0) continue;
      auto picture = prepare_picture_insert(db, kind);
      if (!picture) return tl::unexpected(picture.error());
      insert_picture.emplace(kind, std::move(*picture));
    }
    return {};
  }

  Expected<void> begin() { return pending == 0 ? db.exec("BEGIN") : Expected<void>{}; }
  /// Runs a statement that adds a row; true when it is time to commit.
  Expected<bool> add_row(SqliteDb::Statement& statement) {
    auto done = statement.step();
    statement.reset();
    if (!done) {
      abandon();
      return done;
    }
    return ++pending >= kTilesPerTransaction;
  }

  /// Drops what is not committed, after a failure.
  void abandon() {
    pending = 0;
    static_cast<void>(db.exec("ROLLBACK"));
  }

  Expected<void> complete();
  Expected<void> pack();
};

TileWriter::TileWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TileWriter::TileWriter(TileWriter&&) noexcept = default;
TileWriter& TileWriter::operator=(TileWriter&&) noexcept = default;
TileWriter::~TileWriter() {
  if (impl_) static_cast<void>(commit());
}

Expected<TileWriter> TileWriter::create(const std::string& path, const Manifest& manifest) {
  const std::string building = building_path(path);
  if (auto free = check_free(building); !free) return tl::unexpected(free.error());
  // The unfinished tree appears with its manifest in it: whatever is found under its name can be resumed.
  const std::string begun = new_path(building);
  remove_database(begun);
  auto done = begin_file(begun, manifest);
  if (done) {
    remove_database(building);
    done = move_into_place(begun, building);
  }
  if (!done) {
    remove_database(begun);
    return tl::unexpected(done.error());
  }
  return resume(path, manifest);
}

Expected<TileWriter> TileWriter::resume(const std::string& path, const Manifest& manifest) {
  const std::string building = building_path(path);
  std::error_code ec;
  if (!fs::exists(building, ec))
    return fail(ErrorCode::kUsage, "there is no unfinished build to resume; leave out --resume", path);
  auto db = open_existing(building, SqliteDb::Access::kOwn);
  if (!db) return tl::unexpected(db.error());
  auto before = read_manifest(*db);
  if (!before) return tl::unexpected(before.error());
  if (const std::string difference = before->difference(manifest); !difference.empty()) {
    return fail(ErrorCode::kUsage,
                "the unfinished build differs in " + difference + "; use the same input and options, or --overwrite",
                building);
  }
  auto impl = std::make_unique<Impl>(Impl{path, std::move(*db), manifest, {}, {}, 0});
  if (auto done = impl->prepare(); !done) return tl::unexpected(done.error());
  return TileWriter(std::move(impl));
}

Expected<std::vector<std::int64_t>> TileWriter::keys() const { return read_keys(impl_->db); }

Expected<std::vector<std::int64_t>> TileWriter::picture_keys(PictureKind kind) const {
  return read_picture_keys(impl_->db, kind);
}

Expected<std::uint64_t> TileWriter::picture_bytes(PictureKind kind) const { return sum_picture_bytes(impl_->db, kind); }

Expected<std::optional<std::vector<std::byte>>> TileWriter::read_picture(PictureKind kind,
                                                                         const codec::TileId& id) const {
  return read_picture_row(impl_->db, kind, id);
}

Expected<StoredTile> TileWriter::read(const codec::TileId& id) const { return read_tile(impl_->db, id); }

Expected<void> TileWriter::put(const StoredTile& tile) {
  if (auto begun = impl_->begin(); !begun) return begun;
  bind_tile(*impl_->insert, tile);
  const auto full = impl_->add_row(*impl_->insert);
  if (!full) return tl::unexpected(full.error());
  return *full ? commit() : Expected<void>{};
}

Expected<void> TileWriter::put_picture(PictureKind kind, const codec::TileId& id, std::span<const std::byte> payload) {
  if (auto begun = impl_->begin(); !begun) return begun;
  SqliteDb::Statement& insert = impl_->insert_picture.at(kind);
  bind_picture(insert, id, payload);
  const auto full = impl_->add_row(insert);
  if (!full) return tl::unexpected(full.error());
  return *full ? commit() : Expected<void>{};
}

Expected<void> TileWriter::commit() {
  if (impl_->pending == 0) return {};
  auto done = impl_->db.exec("COMMIT");
  if (!done) impl_->abandon();
  impl_->pending = 0;
  return done;
}

/// Stores the hierarchy, the digest and that all is there.
Expected<void> TileWriter::Impl::complete() {
  std::vector<TileInfo> tiles;
  TreeDigest digest;
  auto digested = for_each_tile(db, [&](const StoredTile& tile) {
    digest.add(tile);
    tiles.push_back(tile.info);
  });
  if (digested) digested = add_pictures(db, manifest, digest);
  if (!digested) return digested;
  manifest.digest = digest.text();
  manifest.complete = true;
  const std::vector<std::byte> bounds = TileBounds(manifest.layout, tiles).to_bytes();
  auto done = db.exec("BEGIN");
  if (done) done = write_metadata(db, "bounds", bounds);
  if (done) done = write_manifest(db, manifest);
  if (done) done = db.exec("COMMIT");
  return done;
}

/// Writes a packed copy: rows in key order, pages of the size that takes the least room, none of them free, no
/// write-ahead log. It grows in the goal's folder, where
/// there has to be room for it, and the unfinished file stays as it is until the copy has its place.
Expected<void> TileWriter::Impl::pack() {
  const auto size = packed_size(db, manifest);
  if (!size) return tl::unexpected(size.error());
  if (auto set = db.exec(fmt::format("PRAGMA page_size = {}", size->page_bytes()).c_str()); !set) return set;
  const std::string packed = packed_path(db.path());
  remove_database(packed);
  auto statement = db.prepare("VACUUM INTO ?");
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, packed);
  auto done = statement->step();
  auto moved = done ? move_into_place(packed, goal) : tl::unexpected(done.error());
  if (!moved) remove_database(packed);
  return moved;
}

Expected<std::string> TileWriter::finish(const StopFlag* stop) {
  impl_->db.set_stop(stop);
  auto done = commit();
  if (done) done = impl_->complete();
  if (done && is_set(stop)) done = fail(ErrorCode::kStopped, "stopped");
  if (done) done = impl_->pack();
  impl_->db.set_stop(nullptr);
  if (!done) return tl::unexpected(done.error());
  const std::string building = impl_->db.path();
  const std::string digest = impl_->manifest.digest;
  impl_.reset();
  remove_build(building);
  return digest;
}

}  // namespace tintree::cache
