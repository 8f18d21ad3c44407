#pragma once

#include <functional>
#include <vector>

#include "apps/audit/image_audit.h"
#include "apps/audit/viewpoints.h"

namespace tintree::audit {

/// audit_images() of the views that `choose` names, given the DEM's greatest height; `options` gives the pixel error
/// and the size, which is that of all cameras.
Expected<ImageReport> audit_views(const AuditContext& context, const ImageOptions& options,
                                  const std::function<std::vector<Viewpoint>(double highest_m)>& choose,
                                  std::vector<Violation>& violations);

}  // namespace tintree::audit
