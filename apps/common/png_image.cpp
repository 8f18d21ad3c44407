#include "apps/common/png_image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

namespace tintree::app {

Expected<std::string> encode_png(int width_px, int height_px, std::span<const std::uint8_t> rgb) {
  OIIO::Filesystem::IOVecOutput memory;
  const auto out = OIIO::ImageOutput::create("png", &memory);
  if (!out) return fail(ErrorCode::kIo, "OpenImageIO cannot write PNG: " + OIIO::geterror());
  OIIO::ImageSpec spec(width_px, height_px, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  const bool written =
      out->open("picture.png", spec) && out->write_image(OIIO::TypeDesc::UINT8, rgb.data()) && out->close();
  if (!written) return fail(ErrorCode::kIo, "the picture cannot be coded: " + out->geterror());
  const std::vector<unsigned char>& bytes = memory.buffer();
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Expected<std::string> png_data_uri(const RgbImage& image) {
  const auto bytes = encode_png(image.width_px, image.height_px, image.rgb);
  if (!bytes) return tl::unexpected(bytes.error());
  return "data:image/png;base64," + OIIO::Strutil::base64_encode(*bytes);
}

}  // namespace tintree::app
