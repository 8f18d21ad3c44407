#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "apps/audit/image_report.h"
#include "apps/audit/picture_audit.h"
#include "apps/audit/tree_audit.h"

namespace tintree::audit {

/// The levels as a table, CGAL's lines and the worst violations, as a program prints them.
/// `images` and `pictures` may be null.
std::string report_text(const TreeReport& report, const ImageReport* images, const PictureReport* pictures = nullptr);

/// "PASS: ..." or "FAIL: N violations; worst: tile l/x/y ...", one line.
std::string verdict(const TreeReport& report);

/// The violations, the most severe first.
std::vector<Violation> by_severity(const TreeReport& report);

/// The report for --json (docs/guide.md names the keys).
nlohmann::ordered_json report_json(const TreeReport& report, const ImageReport* images,
                                   const PictureReport* pictures = nullptr);

}  // namespace tintree::audit
