#include "apps/audit/image_audit.h"

namespace tintree::audit {

Expected<ImageReport> audit_images(const AuditContext& /*context*/, const ImageOptions& /*options*/,
                                   std::vector<Violation>& /*violations*/) {
  return fail(ErrorCode::kUsage, "this build cannot draw pictures; leave out --images, or build with the viewer");
}

}  // namespace tintree::audit
