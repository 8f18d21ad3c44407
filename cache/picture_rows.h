#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cache/sqlite_db.h"
#include "codec/error.h"
#include "codec/tile_id.h"

namespace tintree::cache {

/// What lies on a tile besides its mesh; the tables `texture` and `normal` (docs/format.md).
enum class PictureKind : std::uint8_t { kTexture = 1, kNormal = 2 };
inline constexpr std::array kPictureKinds{PictureKind::kTexture, PictureKind::kNormal};

/// "texture" or "normal map", as messages say it.
const char* picture_name(PictureKind kind);
/// The tables' rows, as TileStore and TileWriter read and write them.
Expected<void> create_picture_table(SqliteDb& db, PictureKind kind);
Expected<SqliteDb::Statement> prepare_picture_insert(const SqliteDb& db, PictureKind kind);
/// Fills the statement in; the payload must outlive the next step.
void bind_picture(SqliteDb::Statement& insert, const codec::TileId& id, std::span<const std::byte> payload);

/// A payload whose checksum holds (kBadData when it does not), or nothing where the tile has no such picture.
Expected<std::optional<std::vector<std::byte>>> read_picture_row(const SqliteDb& db, PictureKind kind,
                                                                 const codec::TileId& id);
/// Hands every payload to `visit` in key order, its checksum verified.
Expected<void> for_each_picture(const SqliteDb& db, PictureKind kind,
                                const std::function<void(const codec::TileId&, std::span<const std::byte>)>& visit);
/// Bytes of every payload, in key order.
Expected<std::vector<std::int64_t>> picture_sizes(const SqliteDb& db, PictureKind kind);
/// Bytes of all payloads.
Expected<std::uint64_t> sum_picture_bytes(const SqliteDb& db, PictureKind kind);
/// The keys of all rows, ascending.
Expected<std::vector<std::int64_t>> read_picture_keys(const SqliteDb& db, PictureKind kind);

}  // namespace tintree::cache
