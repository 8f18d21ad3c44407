#include "apps/common/json_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>
#include <sys/resource.h>

namespace tintree::app {

Expected<void> write_json(const std::string& path, const nlohmann::ordered_json& value) {
  const std::string temporary = path + ".tmp";
  std::ofstream out(temporary);
  out << value.dump(2) << '\n';
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

std::uint64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace tintree::app
