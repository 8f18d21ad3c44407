#include "apps/common/json_file.h"

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "apps/common/whole_file.h"

namespace tintree::app {

Expected<void> write_json(const std::string& path, const nlohmann::ordered_json& value) {
  return write_whole_file(path, value.dump(2) + '\n');
}

std::uint64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace tintree::app
