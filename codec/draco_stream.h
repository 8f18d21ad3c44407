#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tintree::codec {

/// A Draco stream as a payload holds it: without what every stream of a tile says alike, which in a small tile is a
/// tenth of it (docs/format.md, Payload). Knows Draco's format (bit stream 2.2), not the library.

/// Appends the stream to `packed`; false when it is no Edgebreaker mesh with one attribute of three integers.
bool pack_draco_stream(std::span<const std::byte> stream, std::vector<std::byte>& packed);

/// The stream of a packed one, to the last bit; false when that is damaged in a way that shows here.
bool unpack_draco_stream(std::span<const std::byte> packed, std::vector<std::byte>& stream);

}  // namespace tintree::codec
