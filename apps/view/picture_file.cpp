#include "apps/view/picture_file.h"

#include <filesystem>

#include <OpenImageIO/imageio.h>

namespace tintree::view {

Expected<void> write_png(const std::string& path, const render::Picture& picture) {
  const std::string temporary = path + ".tmp";
  std::error_code ec;
  const auto out = OIIO::ImageOutput::create("png");
  if (!out) return fail(ErrorCode::kIo, "OpenImageIO cannot write PNG: " + OIIO::geterror(), path);
  OIIO::ImageSpec spec(picture.width_px, picture.height_px, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  const bool written =
      out->open(temporary, spec) && out->write_image(OIIO::TypeDesc::UINT8, picture.rgb.data()) && out->close();
  if (!written) {
    const std::string reason = out->geterror();
    std::filesystem::remove(temporary, ec);
    return fail(ErrorCode::kIo, "cannot be written: " + reason, path);
  }
  std::filesystem::rename(temporary, path, ec);
  if (ec) return fail(ErrorCode::kIo, "cannot be written: " + ec.message(), path);
  return {};
}

}  // namespace tintree::view
