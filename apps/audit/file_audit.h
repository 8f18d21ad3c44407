#pragma once

#include <vector>

#include "apps/audit/tile_audit.h"
#include "apps/audit/violation.h"

namespace tintree::audit {

/// Examines what the file says of itself as a whole: that the manifest's digests are those of the tiles and of
/// the DEM given, that the table's rows are the tiles of the hierarchy, and that every box of the hierarchy
/// lies inside its parent's. Reads the DEM and the file once; memory for two rows of blocks.
Expected<std::vector<Violation>> audit_file(const AuditContext& context);

}  // namespace tintree::audit
