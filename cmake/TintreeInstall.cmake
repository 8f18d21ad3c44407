# Installs the libraries with their headers and a package config for find_package(tintree).

include(CMakePackageConfigHelpers)
get_property(libraries GLOBAL PROPERTY TINTREE_LIBRARIES)
install(TARGETS ${libraries} EXPORT tintree-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(floor codec cache simplify render)
  if(TARGET tintree_${floor})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${floor} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tintree
            FILES_MATCHING PATTERN "*.h")
  endif()
endforeach()
install(EXPORT tintree-targets NAMESPACE tintree:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tintree)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/tintree-config.cmake.in
  ${PROJECT_BINARY_DIR}/tintree-config.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tintree)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tintree-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tintree-config.cmake ${PROJECT_BINARY_DIR}/tintree-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tintree)
