#include "apps/view/picture_file.h"

#include "apps/common/png_image.h"
#include "apps/common/whole_file.h"

namespace tintree::view {

Expected<void> write_png(const std::string& path, const render::Picture& picture) {
  const auto bytes = app::encode_png(picture.width_px, picture.height_px, picture.rgb);
  if (!bytes) return fail(bytes.error().code, bytes.error().message, path);
  return app::write_whole_file(path, *bytes);
}

}  // namespace tintree::view
