#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cache/manifest.h"
#include "cache/picture_rows.h"
#include "cache/tile_bounds.h"
#include "codec/error.h"
#include "codec/mesh_codec.h"
#include "codec/stop_flag.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// A tile as it lies in the file.
struct StoredTile {
  TileInfo info;
  std::vector<std::byte> payload;
};

/// Reads a finished tree (docs/format.md). Safe to use from several threads; reads take turns.
class TileStore {
 public:
  /// Fails with kIo when there is no such file, kBadData when it is no tree, damaged, unfinished or of a
  /// newer format.
  static Expected<TileStore> open(const std::string& path);

  TileStore(TileStore&&) noexcept;
  TileStore& operator=(TileStore&&) noexcept;
  ~TileStore();

  const std::string& path() const;
  const Manifest& manifest() const;
  /// The bounding-box hierarchy; names every tile of the tree.
  const TileBounds& bounds() const;

  /// One tile with its checksum verified; kBadData when it is missing or damaged.
  Expected<StoredTile> read(const codec::TileId& id) const;
  /// The same, decoded and validated: ready for use.
  Expected<codec::TileMesh> read_mesh(const codec::TileId& id) const;
  /// What read() has returned, decoded and validated.
  Expected<codec::TileMesh> decode(const StoredTile& tile) const;
  /// codec::TileDecoder::patch_residual() of a tile.
  Expected<std::optional<codec::PatchResidual>> patch_residual(const codec::TileId& id) const;

  /// The tile's texture or normal map with its checksum verified, or nothing where it has none.
  Expected<std::optional<std::vector<std::byte>>> read_picture(PictureKind kind, const codec::TileId& id) const;
  /// Keys of the tiles that have such a picture, ascending.
  Expected<std::vector<std::int64_t>> picture_keys(PictureKind kind) const;
  /// Bytes of all payloads of such pictures.
  Expected<std::uint64_t> picture_bytes(PictureKind kind) const;

  /// Keys of all rows of the tile table, ascending; in a sound file those of bounds().
  Expected<std::vector<std::int64_t>> keys() const;
  /// The tree's digest, made anew from all tiles as they lie in the file; in a sound file manifest().digest.
  /// kBadData when a tile is damaged.
  Expected<std::string> digest() const;

 private:
  struct Impl;
  explicit TileStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Decodes the tiles of a tree and validates what comes out. Any thread.
class TileDecoder {
 public:
  /// `read` is asked for tiles that others build on; `manifest` and what it needs must outlive the decoder.
  TileDecoder(const Manifest& manifest, std::function<Expected<StoredTile>(const codec::TileId&)> read);

  /// A payload's checksum must hold; errors name the tile.
  Expected<codec::TileMesh> decode(const StoredTile& tile) const;
  /// Of a tile that could be decoded.
  Expected<std::optional<codec::PatchResidual>> patch_residual(const codec::TileId& id) const {
    return decoder_->patch_residual(id);
  }

 private:
  const Manifest* manifest_;
  std::unique_ptr<codec::TileDecoder> decoder_;
};

/// Writes a tree. Until finish() the file lies beside its goal under building_path(), where a build that
/// was stopped or killed can go on. It belongs to one writer at a time: another fails with kIo. Not thread-safe.
class TileWriter {
 public:
  static std::string building_path(const std::string& path) { return path + ".building"; }

  /// Begins a new tree that will become `path`; an unfinished one there is discarded.
  static Expected<TileWriter> create(const std::string& path, const Manifest& manifest);
  /// Goes on with the unfinished tree of `path`; kUsage when there is none or it was begun otherwise.
  static Expected<TileWriter> resume(const std::string& path, const Manifest& manifest);

  TileWriter(TileWriter&&) noexcept;
  TileWriter& operator=(TileWriter&&) noexcept;
  /// Commits what has been put; the unfinished tree stays resumable.
  ~TileWriter();

  /// Keys of all tiles there, ascending.
  Expected<std::vector<std::int64_t>> keys() const;
  Expected<StoredTile> read(const codec::TileId& id) const;
  /// The same of tiles' pictures, of a kind that the manifest announces.
  Expected<std::vector<std::int64_t>> picture_keys(PictureKind kind) const;
  Expected<std::uint64_t> picture_bytes(PictureKind kind) const;
  Expected<std::optional<std::vector<std::byte>>> read_picture(PictureKind kind, const codec::TileId& id) const;
  /// Adds a tile, or replaces it.
  Expected<void> put(const StoredTile& tile);
  /// Adds a picture of a tile, or replaces it.
  Expected<void> put_picture(PictureKind kind, const codec::TileId& id, std::span<const std::byte> payload);
  /// Makes everything put so far survive the end of the process, kill -9 included. put() also does so by itself now
  /// and then.
  Expected<void> commit();
  /// All tiles are there and measured: stores the hierarchy and the digest, and puts a packed copy into its
  /// place, replacing what is there; needs room for that copy. Returns the digest. kStopped once `stop` is set; after
  /// any failure the unfinished tree stays resumable.
  Expected<std::string> finish(const StopFlag* stop = nullptr);

 private:
  struct Impl;
  explicit TileWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tintree::cache
