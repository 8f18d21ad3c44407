# Defines OpenImageIO::OpenImageIO from the library's pkg-config file. Debian's own CMake package cannot be
# used without the command-line tools (which bring Qt) and the OpenCV headers, of which we need neither.

find_package(PkgConfig REQUIRED)
pkg_check_modules(PC_OpenImageIO QUIET IMPORTED_TARGET OpenImageIO)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenImageIO
  REQUIRED_VARS PC_OpenImageIO_LINK_LIBRARIES VERSION_VAR PC_OpenImageIO_VERSION)
if(OpenImageIO_FOUND AND NOT TARGET OpenImageIO::OpenImageIO)
  add_library(OpenImageIO::OpenImageIO INTERFACE IMPORTED)
  target_link_libraries(OpenImageIO::OpenImageIO INTERFACE PkgConfig::PC_OpenImageIO)
endif()
