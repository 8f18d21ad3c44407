#pragma once

#include <optional>
#include <string>

#include "apps/audit/image_report.h"
#include "apps/audit/picture_audit.h"
#include "apps/audit/tree_audit.h"

namespace tintree::audit {

/// Everything that the page shows.
struct ReportInput {
  const AuditContext& context;
  const TreeReport& tree;                   ///< Measured with AuditOptions::map_px > 0.
  const ImageReport* images = nullptr;      ///< Null when pictures were not compared.
  const PictureReport* pictures = nullptr;  ///< Null when the tree has no textures or normal maps.
};

/// Makes the report: one HTML page that holds its pictures and needs nothing else. The verdict first, then what
/// was checked, a table of the levels, histograms, error maps, the worst tiles in pictures, and the sizes.
/// Reads the worst tiles and a thinned-out DEM again.
Expected<std::string> report_page(const ReportInput& input);

}  // namespace tintree::audit
