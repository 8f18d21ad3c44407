#pragma once

#include <string>

#include "apps/audit/report_page.h"

namespace tintree::audit {

/// The report's sections of pictures; each adds itself to the page.

/// The terrain, and one map of measured errors a level.
Expected<void> put_maps(std::string& out, const ReportInput& input);
/// The worst tiles: DEM, mesh, errors.
Expected<void> put_worst_tiles(std::string& out, const ReportInput& input);
/// The views compared pixel by pixel; nothing when there are none.
Expected<void> put_views(std::string& out, const ReportInput& input);

}  // namespace tintree::audit
