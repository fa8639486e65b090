# SPDX-License-Identifier: BSD-3-Clause
# Dependencies of core and the message types, and of all programs that link them: this file is also part of the
# installed CMake package. All of them are Debian 12 packages (scripts/setup installs them).
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc features2d)
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(BZip2 REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(spdlog REQUIRED)

# Debian's LCM has no CMake package, and its pkg-config file requires GLib's headers, which its users do not need.
if(NOT TARGET lcm::lcm)
  find_path(LCM_INCLUDE_DIR lcm/lcm-cpp.hpp REQUIRED)
  find_library(LCM_LIBRARY lcm REQUIRED)
  add_library(lcm::lcm UNKNOWN IMPORTED)
  set_target_properties(lcm::lcm PROPERTIES IMPORTED_LOCATION ${LCM_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${LCM_INCLUDE_DIR})
endif()

if(NOT TARGET sodium::sodium)
  find_path(SODIUM_INCLUDE_DIR sodium.h REQUIRED)
  find_library(SODIUM_LIBRARY sodium REQUIRED)
  add_library(sodium::sodium UNKNOWN IMPORTED)
  set_target_properties(sodium::sodium PROPERTIES IMPORTED_LOCATION ${SODIUM_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${SODIUM_INCLUDE_DIR})
endif()

# Debian's libdeflate, zstd and lz4 have no CMake packages.
if(NOT TARGET deflate::deflate)
  find_path(DEFLATE_INCLUDE_DIR libdeflate.h REQUIRED)
  find_library(DEFLATE_LIBRARY deflate REQUIRED)
  add_library(deflate::deflate UNKNOWN IMPORTED)
  set_target_properties(deflate::deflate PROPERTIES IMPORTED_LOCATION ${DEFLATE_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${DEFLATE_INCLUDE_DIR})
endif()
foreach(codec zstd lz4)
  if(NOT TARGET ${codec}::${codec})
    string(TOUPPER ${codec} CODEC)
    find_path(${CODEC}_INCLUDE_DIR ${codec}.h REQUIRED)
    find_library(${CODEC}_LIBRARY ${codec} REQUIRED)
    add_library(${codec}::${codec} UNKNOWN IMPORTED)
    set_target_properties(${codec}::${codec} PROPERTIES IMPORTED_LOCATION ${${CODEC}_LIBRARY}
                          INTERFACE_INCLUDE_DIRECTORIES ${${CODEC}_INCLUDE_DIR})
  endif()
endforeach()

# One include directory for all of OpenCV, as SYSTEM (imported), so that its headers cause no warnings.
if(NOT TARGET plslam_opencv)
  add_library(plslam_opencv INTERFACE IMPORTED)
  set_target_properties(plslam_opencv PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${OpenCV_INCLUDE_DIRS}")
endif()
