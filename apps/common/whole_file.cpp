#include "apps/common/whole_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <unistd.h>

namespace tintree::app {

namespace fs = std::filesystem;

namespace {

/// A device or a pipe, which is written to and must not be replaced by a file (/dev/null by root, say).
bool is_device(const std::string& path) {
  std::error_code ec;
  const fs::file_status status = fs::status(path, ec);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

}  // namespace

std::string folder_of(const std::string& path) {
  const std::string parent = fs::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}

Expected<void> check_output_file(const std::string& path, std::span<const std::string> inputs) {
  std::error_code ec;
  if (is_device(path)) return {};
  for (const std::string& input : inputs) {
    if (fs::equivalent(path, input, ec))
      return fail(ErrorCode::kUsage, "is read and would be lost; name another file to write", path);
  }
  if (fs::is_directory(path, ec)) return fail(ErrorCode::kIo, "is a directory; name a file", path);
  const std::string folder = folder_of(path);
  if (!fs::is_directory(folder, ec))
    return fail(ErrorCode::kIo, "there is no folder " + folder + "; create it first", path);
  if (::access(folder.c_str(), W_OK) != 0)
    return fail(ErrorCode::kIo, "the folder may not be written to; check its permissions", folder);
  return {};
}

Expected<void> write_whole_file(const std::string& path, std::string_view bytes) {
  std::error_code ec;
  const bool direct = is_device(path);
  const std::string temporary = direct ? path : path + ".tmp";
  std::ofstream out(temporary, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) {
    const int reason = errno;
    if (!direct) fs::remove(temporary, ec);
    return fail(ErrorCode::kIo, std::string("cannot be written: ") + std::strerror(reason), path);
  }
  if (direct) return {};
  fs::rename(temporary, path, ec);
  if (ec) return fail(ErrorCode::kIo, "cannot be written: " + ec.message(), path);
  return {};
}

}  // namespace tintree::app
