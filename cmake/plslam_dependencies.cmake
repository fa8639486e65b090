# Everything the tree links, found once.
include(plslam_core_dependencies)
find_package(nlohmann_json REQUIRED)
find_program(LCM_GEN lcm-gen REQUIRED)

# Debian's zstd has no CMake package.
find_package(ZLIB REQUIRED)
find_path(ZSTD_INCLUDE_DIR zstd.h REQUIRED)
find_library(ZSTD_LIBRARY zstd REQUIRED)
add_library(zstd::zstd UNKNOWN IMPORTED)
set_target_properties(zstd::zstd PROPERTIES IMPORTED_LOCATION ${ZSTD_LIBRARY}
                      INTERFACE_INCLUDE_DIRECTORIES ${ZSTD_INCLUDE_DIR})
