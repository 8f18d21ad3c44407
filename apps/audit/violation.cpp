#include "apps/audit/violation.h"

namespace tintree::audit {

const char* kind_name(ViolationKind kind) {
  switch (kind) {
    case ViolationKind::kFile:
      return "file";
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
    case ViolationKind::kBound:
      return "bound";
    case ViolationKind::kStoredFigure:
      return "stored_figure";
    case ViolationKind::kHausdorff:
      return "hausdorff";
  }
  return "unknown";
}

}  // namespace tintree::audit
