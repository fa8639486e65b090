# SPDX-License-Identifier: BSD-3-Clause
# Precompiled headers of other projects that most sources include (PLSLAM_PRECOMPILE; set by the presets release and
# asan). Sources still include what they use: all other builds, and clang-tidy, work without them.
option(PLSLAM_PRECOMPILE "Precompile the headers of other libraries" OFF)
set(PLSLAM_COMMON_HEADERS
    <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <cstdint> <deque> <filesystem> <fstream> <functional>
    <limits> <map> <memory> <mutex> <optional> <random> <set> <span> <sstream> <stdexcept> <string> <string_view> <thread>
    <utility> <variant> <vector> <Eigen/Core> <Eigen/Geometry> <opencv2/core/mat.hpp> <fmt/format.h>)

# plslam_precompile(NAME LINK target ... HEADERS <header> ...): for targets with the same flags (plslam_use_precompiled).
# GCC rejects it with an error if a command line macro used by a header differs.
function(plslam_precompile name)
  if(NOT PLSLAM_PRECOMPILE)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "LINK;HEADERS" ${ARGN})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${source})
  target_link_libraries(${name} PRIVATE plslam_flags ${ARG_LINK})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

function(plslam_use_precompiled name precompiled)
  if(PLSLAM_PRECOMPILE)
    target_precompile_headers(${name} REUSE_FROM ${precompiled})
  endif()
endfunction()

if(PLSLAM_PRECOMPILE)
  # The macro of fmt's shared library, also for targets that do not link fmt.
  target_compile_definitions(plslam_flags INTERFACE $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)
  # Without these, ccache recompiles everything (its manual, PRECOMPILED HEADERS).
  target_compile_options(plslam_flags INTERFACE -fpch-preprocess)
  if(CCACHE_PROGRAM)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE_PROGRAM})
  endif()
endif()
plslam_precompile(plslam_common_headers LINK Eigen3::Eigen plslam_opencv fmt::fmt HEADERS ${PLSLAM_COMMON_HEADERS})
plslam_precompile(plslam_tool_headers LINK plslam_light_flags Eigen3::Eigen plslam_opencv fmt::fmt HEADERS ${PLSLAM_COMMON_HEADERS})
