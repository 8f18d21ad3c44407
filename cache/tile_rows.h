#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "cache/manifest.h"
#include "cache/packed_size.h"
#include "cache/sqlite_db.h"
#include "cache/tile_digest.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/tile_id.h"

namespace tintree::cache {

/// The tables of a .tintree file (docs/format.md), and what their rows hold: what TileStore and TileWriter have in
/// common.

inline constexpr const char* kInsertTile = "INSERT OR REPLACE INTO tile VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)";

/// Turns an empty database into a tree without tiles or metadata, in WAL mode, with the tables that the manifest needs.
Expected<void> create_tables(SqliteDb& db, const Manifest& manifest);
/// Opens an existing tree and checks that it is one that this program can read.
Expected<SqliteDb> open_existing(const std::string& path, SqliteDb::Access access);

/// Fills in kInsertTile; the tile must outlive the next step.
void bind_tile(SqliteDb::Statement& insert, const StoredTile& tile);
/// Reads a tile; kBadData when it is not there or its checksum does not hold.
Expected<StoredTile> read_tile(const SqliteDb& db, const codec::TileId& id);
/// Hands every tile to `visit` in key order, its checksum verified.
Expected<void> for_each_tile(const SqliteDb& db, const std::function<void(const StoredTile&)>& visit);
/// Adds all textures and normal maps to a digest that has the tiles.
Expected<void> add_pictures(const SqliteDb& db, const Manifest& manifest, TreeDigest& digest);
/// What the tables come to in a file of their own.
Expected<PackedSize> packed_size(const SqliteDb& db, const Manifest& manifest);
/// The keys of all tiles, ascending.
Expected<std::vector<std::int64_t>> read_keys(const SqliteDb& db);

Expected<std::vector<std::byte>> read_metadata(const SqliteDb& db, const std::string& name);
Expected<void> write_metadata(const SqliteDb& db, const std::string& name, std::span<const std::byte> value);
Expected<Manifest> read_manifest(const SqliteDb& db);
Expected<void> write_manifest(const SqliteDb& db, const Manifest& manifest);

}  // namespace tintree::cache
