#include "apps/common/whole_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace tintree::app {

Expected<void> write_whole_file(const std::string& path, std::string_view bytes) {
  const std::string temporary = path + ".tmp";
  std::ofstream out(temporary, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  std::error_code ec;
  if (!out) {
    const int reason = errno;
    std::filesystem::remove(temporary, ec);
    return fail(ErrorCode::kIo, std::string("cannot be written: ") + std::strerror(reason), path);
  }
  std::filesystem::rename(temporary, path, ec);
  if (ec) return fail(ErrorCode::kIo, "cannot be written: " + ec.message(), path);
  return {};
}

}  // namespace tintree::app
