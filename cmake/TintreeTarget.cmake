# How every target of ours is compiled: C++20, warnings as errors, no contraction of floating-point
# operations (one input gives the same tiles on every machine), includes rooted at the repository.

find_program(TINTREE_CCACHE ccache)
if(TINTREE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TINTREE_CCACHE})
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)  # for clang-tidy

function(tintree_compile target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wconversion -Werror -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -Wno-restrict)  # false alarms over "text" + std::string (GCC bug 105651)
  endif()
endfunction()

# A library that is one floor of the house: tintree_library(codec SOURCES ... PUBLIC ... PRIVATE ...)
function(tintree_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(tintree_${name} STATIC ${ARG_SOURCES})
  add_library(tintree::${name} ALIAS tintree_${name})
  set_target_properties(tintree_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(tintree_${name} PUBLIC cxx_std_20)
  target_include_directories(tintree_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/tintree>)
  target_link_libraries(tintree_${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  tintree_compile(tintree_${name})
  set_property(GLOBAL APPEND PROPERTY TINTREE_LIBRARIES tintree_${name})
endfunction()

# A program: tintree_program(tintree-build SOURCES ... LINK ...)
function(tintree_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
  tintree_compile(${name})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
