#include "cache/gdal_message.h"

#include <cpl_error.h>

namespace tintree::cache {

std::string last_gdal_message() {
  const std::string message = CPLGetLastErrorMsg();
  return message.empty() ? "GDAL gives no reason" : message;
}

}  // namespace tintree::cache
