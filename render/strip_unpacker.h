#pragma once

#include <memory>
#include <utility>

#include "codec/error.h"
#include "render/gl_functions.h"
#include "render/strip_decoder.h"
#include "render/strip_normals.h"

namespace tintree::render {

/// What a strip needs to be made on the card.
struct StripUnpacker {
  StripDecoder decoder;
  std::unique_ptr<StripNormals> normals;

  /// For buffers of at most `buffer_bytes`. Fails with kIo when the driver refuses a shader.
  static Expected<std::unique_ptr<StripUnpacker>> create(const GlFunctions& gl, std::int64_t buffer_bytes) {
    auto decoder = StripDecoder::create(gl, std::nullopt, buffer_bytes);
    if (!decoder) return tl::unexpected(decoder.error());
    auto normals = StripNormals::create(gl);
    if (!normals) return tl::unexpected(normals.error());
    return std::unique_ptr<StripUnpacker>(new StripUnpacker{std::move(*decoder), std::move(*normals)});
  }
};

}  // namespace tintree::render
