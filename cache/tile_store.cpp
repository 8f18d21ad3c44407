#include "cache/tile_store.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fcntl.h>
#include <unistd.h>
#include <xxhash.h>

#include "cache/sqlite_db.h"
#include "cache/tile_digest.h"
#include "codec/mesh_codec.h"

namespace tintree::cache {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kApplicationId = 0x54494e54;  // "TINT"
constexpr std::int64_t kFormatVersion = 1;
constexpr int kTilesPerTransaction = 256;

constexpr const char* kSchema =
    "PRAGMA page_size = 16384;"
    "PRAGMA journal_mode = WAL;"
    "PRAGMA synchronous = NORMAL;"
    "PRAGMA application_id = 1414090324;"
    "PRAGMA user_version = 1;"
    "CREATE TABLE metadata (name TEXT PRIMARY KEY, value BLOB NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID;"
    "CREATE TABLE tile (key INTEGER PRIMARY KEY, vertices INTEGER NOT NULL, triangles INTEGER NOT NULL,"
    " z_min_m REAL NOT NULL, z_max_m REAL NOT NULL, error_m REAL NOT NULL, rms_m REAL NOT NULL,"
    " border_error_m REAL NOT NULL, checksum INTEGER NOT NULL, payload BLOB NOT NULL);";

constexpr const char* kSelectTile =
    "SELECT key, vertices, triangles, z_min_m, z_max_m, error_m, rms_m, border_error_m, checksum, payload"
    " FROM tile WHERE key = ?";
constexpr const char* kSelectAllTiles =
    "SELECT key, vertices, triangles, z_min_m, z_max_m, error_m, rms_m, border_error_m, checksum, payload"
    " FROM tile ORDER BY key";

std::int64_t checksum_of(std::span<const std::byte> bytes) {
  return static_cast<std::int64_t>(XXH3_64bits(bytes.data(), bytes.size()));
}

/// Reads the tile in the statement's current row.
Expected<StoredTile> tile_in_row(const SqliteDb::Statement& row, const std::string& path) {
  StoredTile tile;
  tile.info.id = codec::TileId::from_key(row.integer(0));
  tile.info.vertices = static_cast<std::uint32_t>(row.integer(1));
  tile.info.triangles = static_cast<std::uint32_t>(row.integer(2));
  tile.info.z_min_m = row.real(3);
  tile.info.z_max_m = row.real(4);
  tile.info.error_m = row.real(5);
  tile.info.rms_m = row.real(6);
  tile.info.border_error_m = row.real(7);
  const auto payload = row.blob(9);
  tile.payload.assign(payload.begin(), payload.end());
  if (checksum_of(tile) != row.integer(8)) {
    return fail(ErrorCode::kBadData,
                fmt::format("tile {} is damaged (its checksum does not hold); build the file again or restore a copy",
                            tile.info.id.text()),
                path);
  }
  return tile;
}

Expected<StoredTile> read_tile(const SqliteDb& db, const codec::TileId& id) {
  auto statement = db.prepare(kSelectTile);
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, id.key());
  auto row = statement->step();
  if (!row) return tl::unexpected(row.error());
  if (!*row) return fail(ErrorCode::kBadData, fmt::format("tile {} is missing", id.text()), db.path());
  return tile_in_row(*statement, db.path());
}

/// Hands every row to `visit` in key order, its checksum verified.
template <typename Visit>
Expected<void> for_each_tile(const SqliteDb& db, const Visit& visit) {
  auto statement = db.prepare(kSelectAllTiles);
  if (!statement) return tl::unexpected(statement.error());
  while (true) {
    auto row = statement->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return {};
    auto tile = tile_in_row(*statement, db.path());
    if (!tile) return tl::unexpected(tile.error());
    visit(*tile);
  }
}

Expected<std::vector<std::int64_t>> read_keys(const SqliteDb& db) {
  auto statement = db.prepare("SELECT key FROM tile ORDER BY key");
  if (!statement) return tl::unexpected(statement.error());
  std::vector<std::int64_t> keys;
  while (true) {
    auto row = statement->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return keys;
    keys.push_back(statement->integer(0));
  }
}

Expected<std::vector<std::byte>> read_metadata(const SqliteDb& db, const std::string& name) {
  auto statement = db.prepare("SELECT value, checksum FROM metadata WHERE name = ?");
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, name);
  auto row = statement->step();
  if (!row) return tl::unexpected(row.error());
  if (!*row) return fail(ErrorCode::kBadData, "holds no " + name + "; the file is incomplete", db.path());
  const auto value = statement->blob(0);
  if (checksum_of(value) != statement->integer(1)) {
    return fail(ErrorCode::kBadData, "its " + name + " is damaged; build the file again or restore a copy", db.path());
  }
  return std::vector<std::byte>(value.begin(), value.end());
}

Expected<void> write_metadata(const SqliteDb& db, const std::string& name, std::span<const std::byte> value) {
  auto statement = db.prepare("INSERT OR REPLACE INTO metadata VALUES (?, ?, ?)");
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, name);
  statement->bind(2, value);
  statement->bind(3, checksum_of(value));
  if (auto done = statement->step(); !done) return tl::unexpected(done.error());
  return {};
}

Expected<Manifest> read_manifest(const SqliteDb& db) {
  auto bytes = read_metadata(db, "manifest");
  if (!bytes) return tl::unexpected(bytes.error());
  auto manifest = Manifest::from_json(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
  if (!manifest) manifest.error().where = db.path();
  return manifest;
}

Expected<void> write_manifest(const SqliteDb& db, const Manifest& manifest) {
  const std::string json = manifest.to_json();
  return write_metadata(db, "manifest", std::as_bytes(std::span(json)));
}

/// Opens an existing tree and checks that it is one that this program can read.
Expected<SqliteDb> open_existing(const std::string& path, int flags) {
  std::error_code ec;
  if (!fs::exists(path, ec)) return fail(ErrorCode::kIo, "no such file", path);
  if (fs::is_directory(path, ec)) return fail(ErrorCode::kIo, "is a directory, not a tintree file", path);
  auto db = SqliteDb::open(path, flags);
  if (!db) return db;
  const auto application = db->query_integer("PRAGMA application_id");
  if (!application) return tl::unexpected(application.error());
  if (*application != kApplicationId) return fail(ErrorCode::kBadData, "is no tintree file", path);
  const auto version = db->query_integer("PRAGMA user_version");
  if (!version) return tl::unexpected(version.error());
  if (*version > kFormatVersion) {
    return fail(ErrorCode::kBadData,
                fmt::format("has format version {}, newer than the {} this program reads; update tintree", *version,
                            kFormatVersion),
                path);
  }
  if (*version < 1) return fail(ErrorCode::kBadData, "is damaged (no format version)", path);
  const auto page_size = db->query_integer("PRAGMA page_size");
  if (!page_size) return tl::unexpected(page_size.error());
  const auto size = fs::file_size(path, ec);
  if (size % static_cast<std::uint64_t>(*page_size) != 0) {
    return fail(ErrorCode::kBadData, "is cut short; build the file again or restore a copy", path);
  }
  return db;
}

Expected<void> sync_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail(ErrorCode::kIo, std::strerror(errno), path);
  const int rc = ::fsync(fd);
  const int reason = errno;
  ::close(fd);
  if (rc != 0) return fail(ErrorCode::kIo, std::strerror(reason), path);
  return {};
}

void remove_database(const std::string& path) {
  std::error_code ec;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) fs::remove(path + suffix, ec);
}

}  // namespace

Expected<codec::TileMesh> decode_tile(const Manifest& manifest, const StoredTile& tile) {
  const codec::MeshCodec* codec = codec::find_codec(manifest.method);
  if (codec == nullptr) return fail(ErrorCode::kBadData, "method '" + manifest.method + "' is unknown; update tintree");
  auto mesh = codec->decode(tile.payload);
  if (mesh) {
    auto valid = codec::validate(*mesh, manifest.layout.cells_across(tile.info.id.level));
    if (!valid) mesh = tl::unexpected(valid.error());
  }
  if (!mesh) mesh.error().where = "tile " + tile.info.id.text();
  return mesh;
}

struct TileStore::Impl {
  Impl(SqliteDb d, Manifest m, TileBounds b) : db(std::move(d)), manifest(std::move(m)), bounds(std::move(b)) {}

  SqliteDb db;
  Manifest manifest;
  TileBounds bounds;
  mutable std::mutex turn;
};

TileStore::TileStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TileStore::TileStore(TileStore&&) noexcept = default;
TileStore& TileStore::operator=(TileStore&&) noexcept = default;
TileStore::~TileStore() = default;

const std::string& TileStore::path() const { return impl_->db.path(); }
const Manifest& TileStore::manifest() const { return impl_->manifest; }
const TileBounds& TileStore::bounds() const { return impl_->bounds; }

Expected<TileStore> TileStore::open(const std::string& path) {
  auto db = open_existing(path, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX);
  if (!db) return tl::unexpected(db.error());
  auto manifest = read_manifest(*db);
  if (!manifest) return tl::unexpected(manifest.error());
  if (!manifest->complete) {
    return fail(ErrorCode::kBadData, "is an unfinished build; finish it with tintree-build --resume", path);
  }
  auto bytes = read_metadata(*db, "bounds");
  if (!bytes) return tl::unexpected(bytes.error());
  auto bounds = TileBounds::from_bytes(manifest->layout, *bytes);
  if (!bounds) {
    bounds.error().where = path;
    return tl::unexpected(bounds.error());
  }
  auto impl = std::make_unique<Impl>(std::move(*db), std::move(*manifest), std::move(*bounds));
  return TileStore(std::move(impl));
}

Expected<StoredTile> TileStore::read(const codec::TileId& id) const {
  const std::scoped_lock lock(impl_->turn);
  return read_tile(impl_->db, id);
}

Expected<std::vector<std::int64_t>> TileStore::keys() const {
  const std::scoped_lock lock(impl_->turn);
  return read_keys(impl_->db);
}

Expected<std::string> TileStore::digest() const {
  const std::scoped_lock lock(impl_->turn);
  TreeDigest digest;
  auto digested = for_each_tile(impl_->db, [&digest](const StoredTile& tile) { digest.add(tile); });
  if (!digested) return tl::unexpected(digested.error());
  return digest.text();
}

Expected<codec::TileMesh> TileStore::read_mesh(const codec::TileId& id) const {
  auto tile = read(id);
  if (!tile) return tl::unexpected(tile.error());
  auto mesh = decode_tile(impl_->manifest, *tile);
  if (!mesh) mesh.error().where = path() + ": " + mesh.error().where;
  return mesh;
}

struct TileWriter::Impl {
  std::string goal;
  SqliteDb db;
  Manifest manifest;
  std::optional<SqliteDb::Statement> insert;
  int pending = 0;

  Expected<void> prepare() {
    auto statement = db.prepare("INSERT OR REPLACE INTO tile VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    if (!statement) return tl::unexpected(statement.error());
    insert.emplace(std::move(*statement));
    return {};
  }
};

TileWriter::TileWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TileWriter::TileWriter(TileWriter&&) noexcept = default;
TileWriter& TileWriter::operator=(TileWriter&&) noexcept = default;
TileWriter::~TileWriter() {
  if (impl_) static_cast<void>(commit());
}

Expected<TileWriter> TileWriter::create(const std::string& path, const Manifest& manifest) {
  const std::string building = building_path(path);
  remove_database(building);
  auto db = SqliteDb::open(building, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX);
  if (!db) return tl::unexpected(db.error());
  auto impl = std::make_unique<Impl>(Impl{path, std::move(*db), manifest, {}, 0});
  auto done = impl->db.exec(kSchema);
  if (done) done = write_manifest(impl->db, manifest);
  if (done) done = impl->prepare();
  if (!done) {
    impl.reset();
    remove_database(building);
    return tl::unexpected(done.error());
  }
  return TileWriter(std::move(impl));
}

Expected<TileWriter> TileWriter::resume(const std::string& path, const Manifest& manifest) {
  const std::string building = building_path(path);
  std::error_code ec;
  if (!fs::exists(building, ec))
    return fail(ErrorCode::kUsage, "there is no unfinished build to resume; leave out --resume", path);
  auto db = open_existing(building, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX);
  if (!db) return tl::unexpected(db.error());
  auto before = read_manifest(*db);
  if (!before) return tl::unexpected(before.error());
  if (const std::string difference = before->difference(manifest); !difference.empty()) {
    return fail(ErrorCode::kUsage,
                "the unfinished build differs in " + difference + "; use the same input and options, or --overwrite",
                building);
  }
  auto impl = std::make_unique<Impl>(Impl{path, std::move(*db), manifest, {}, 0});
  if (auto done = impl->prepare(); !done) return tl::unexpected(done.error());
  return TileWriter(std::move(impl));
}

Expected<std::vector<std::int64_t>> TileWriter::keys() const { return read_keys(impl_->db); }

Expected<StoredTile> TileWriter::read(const codec::TileId& id) const { return read_tile(impl_->db, id); }

Expected<void> TileWriter::put(const StoredTile& tile) {
  if (impl_->pending == 0) {
    if (auto begun = impl_->db.exec("BEGIN"); !begun) return begun;
  }
  SqliteDb::Statement& s = *impl_->insert;
  s.bind(1, tile.info.id.key());
  s.bind(2, std::int64_t{tile.info.vertices});
  s.bind(3, std::int64_t{tile.info.triangles});
  s.bind(4, tile.info.z_min_m);
  s.bind(5, tile.info.z_max_m);
  s.bind(6, tile.info.error_m);
  s.bind(7, tile.info.rms_m);
  s.bind(8, tile.info.border_error_m);
  s.bind(9, checksum_of(tile));
  s.bind(10, std::span<const std::byte>(tile.payload));
  auto done = s.step();
  s.reset();
  if (!done) return tl::unexpected(done.error());
  return ++impl_->pending >= kTilesPerTransaction ? commit() : Expected<void>{};
}

Expected<void> TileWriter::commit() {
  if (impl_->pending == 0) return {};
  impl_->pending = 0;
  return impl_->db.exec("COMMIT");
}

Expected<std::string> TileWriter::finish() {
  if (auto done = commit(); !done) return tl::unexpected(done.error());
  std::vector<TileInfo> tiles;
  TreeDigest digest;
  auto digested = for_each_tile(impl_->db, [&](const StoredTile& tile) {
    digest.add(tile);
    tiles.push_back(tile.info);
  });
  if (!digested) return tl::unexpected(digested.error());
  impl_->manifest.digest = digest.text();
  impl_->manifest.complete = true;
  const std::vector<std::byte> bounds = TileBounds(impl_->manifest.layout, tiles).to_bytes();

  auto done = impl_->db.exec("BEGIN");
  if (done) done = write_metadata(impl_->db, "bounds", bounds);
  if (done) done = write_manifest(impl_->db, impl_->manifest);
  if (done) done = impl_->db.exec("COMMIT");
  impl_->insert.reset();
  // One plain, packed file from here on: rows in key order, no free pages, no write-ahead log beside it.
  if (done) done = impl_->db.exec("VACUUM");
  if (done) done = impl_->db.exec("PRAGMA wal_checkpoint(TRUNCATE)");
  if (done) done = impl_->db.exec("PRAGMA journal_mode = DELETE");
  if (!done) return tl::unexpected(done.error());
  const std::string goal = impl_->goal;
  const std::string building = impl_->db.path();
  const std::string tree_digest = impl_->manifest.digest;
  impl_.reset();
  if (auto synced = sync_file(building); !synced) return tl::unexpected(synced.error());
  std::error_code ec;
  fs::rename(building, goal, ec);
  if (ec) return fail(ErrorCode::kIo, "cannot be put in place: " + ec.message(), goal);
  const std::string folder = fs::path(goal).parent_path().string();
  if (auto synced = sync_file(folder.empty() ? "." : folder); !synced) return tl::unexpected(synced.error());
  return tree_digest;
}

}  // namespace tintree::cache
