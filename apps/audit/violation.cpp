#include "apps/audit/violation.h"

namespace tintree::audit {

const char* kind_name(ViolationKind kind) {
  switch (kind) {
    case ViolationKind::kFile:
      return "file";
    case ViolationKind::kManifest:
      return "manifest";
    case ViolationKind::kHierarchy:
      return "hierarchy";
    case ViolationKind::kMissingTile:
      return "missing_tile";
    case ViolationKind::kExtraTile:
      return "extra_tile";
    case ViolationKind::kTopology:
      return "topology";
    case ViolationKind::kCoverage:
      return "coverage";
    case ViolationKind::kBorder:
      return "border";
    case ViolationKind::kGap:
      return "gap";
    case ViolationKind::kBound:
      return "bound";
    case ViolationKind::kStoredFigure:
      return "stored_figure";
    case ViolationKind::kHausdorff:
      return "hausdorff";
    case ViolationKind::kPicture:
      return "picture";
    case ViolationKind::kImage:
      return "image";
  }
  return "unknown";
}

std::string Violation::text() const { return (tile ? "tile " + tile->text() : std::string("file")) + ": " + message; }

}  // namespace tintree::audit
