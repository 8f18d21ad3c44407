#pragma once

#include <cstdint>
#include <vector>

#include "apps/audit/tile_audit.h"
#include "apps/audit/violation.h"
#include "cache/ortho_source.h"

namespace tintree::audit {

/// What the textures and normal maps of a tree were found to be.
struct PictureReport {
  std::uint64_t textures = 0;     ///< That could be decoded.
  std::uint64_t normal_maps = 0;  ///< The same.
  double photo_rms = 0;           ///< Of the leaves' differences from the photos, steps of 255; 0 when not compared.
  double normal_rms = 0;          ///< Of the leaves' normals' differences from the DEM's: about an angle, rad.
};

/// Examines all textures and normal maps: they are there, decode, lie where what they were made from lies, and show
/// it. Leaves' normal maps are held against the DEM, leaves' textures against `photos` (null: not compared), and
/// coarser pictures against their children. What is wrong is appended to `violations`.
Expected<PictureReport> audit_pictures(const AuditContext& context, const cache::OrthoSource* photos,
                                       std::vector<Violation>& violations);

}  // namespace tintree::audit
