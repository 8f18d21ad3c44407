#pragma once

#include <optional>

#include "apps/audit/tree_audit.h"

namespace tintree::audit {

/// Most DEM cells along the side of the windows that CGAL examines: its cost grows faster than their area.
inline constexpr std::int64_t kProbeCells = 64;

/// Cuts a window out of a tile's mesh and out of the reference surface and lets CGAL measure their
/// symmetric Hausdorff distance. Since the vertical distance bounds it over any part of the plane, it
/// must not exceed the vertical maximum over the window. The window is chosen by `seed`; nothing comes
/// back when the tile cannot be read or no window with surface is found. Where the surfaces lie parallel
/// CGAL cuts them into pieces as small as its error bound, so windows shrink with the level's bound and
/// the error bound is at least 1/500 of their side: at most a few seconds and 200 MiB.
Expected<std::optional<HausdorffReport>> probe_tile(const AuditContext& context, const codec::TileId& id,
                                                    std::uint64_t seed);

}  // namespace tintree::audit
