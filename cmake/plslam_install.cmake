# SPDX-License-Identifier: BSD-3-Clause
# Installation by `cmake --install`, and the CMake package of core. Included last: it installs the targets of the other
# folders. Everything is relative to the prefix, and can be moved as a whole: the programs find share/plslam beside
# their folder.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)
get_property(programs GLOBAL PROPERTY PLSLAM_INSTALLED_PROGRAMS)
get_property(libraries GLOBAL PROPERTY PLSLAM_CORE_LIBRARIES)

# --- licence and changes, in Debian's format and location: files for each package
file(READ ${CMAKE_SOURCE_DIR}/LICENSE LICENSE_TEXT)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/LICENSE)
string(STRIP "${LICENSE_TEXT}" LICENSE_TEXT)
string(REGEX REPLACE "\n" "\n " LICENSE_TEXT " ${LICENSE_TEXT}")
string(REGEX REPLACE "\n \n" "\n .\n" LICENSE_TEXT "${LICENSE_TEXT}")
configure_file(${CMAKE_SOURCE_DIR}/cmake/copyright.in ${CMAKE_BINARY_DIR}/copyright @ONLY)
string(TIMESTAMP PACKAGE_DAY "%a, %d %b %Y 00:00:00 +0000" UTC)
configure_file(${CMAKE_SOURCE_DIR}/cmake/changelog.in ${CMAKE_BINARY_DIR}/changelog @ONLY)
execute_process(COMMAND gzip -9nf ${CMAKE_BINARY_DIR}/changelog COMMAND_ERROR_IS_FATAL ANY)
set(documents ${CMAKE_BINARY_DIR}/copyright ${CMAKE_BINARY_DIR}/changelog.gz)
install(FILES ${documents} DESTINATION share/doc/plslam COMPONENT runtime)
install(FILES ${documents} ${CMAKE_SOURCE_DIR}/NOTICE DESTINATION share/doc/libplslam-dev COMPONENT dev)
install(FILES ${documents} DESTINATION share/doc/python3-plslam COMPONENT python)

# --- component dense: dense_process alone has the libraries of volumes
if(TARGET dense_process)
  list(REMOVE_ITEM programs dense_process plslam_surfaces)
  install(TARGETS dense_process plslam_surfaces RUNTIME DESTINATION bin COMPONENT dense)
  install(FILES ${documents} DESTINATION share/doc/plslam-dense COMPONENT dense)
endif()

# --- component bridge: plslam_bridge alone has the library of WebSockets
if(TARGET plslam_bridge)
  list(REMOVE_ITEM programs plslam_bridge)
  install(TARGETS plslam_bridge RUNTIME DESTINATION bin COMPONENT bridge)
  install(FILES ${documents} DESTINATION share/doc/plslam-bridge COMPONENT bridge)
endif()

# --- component ros2: plslam_ros2 alone has Cyclone DDS
if(TARGET plslam_ros2)
  list(REMOVE_ITEM programs plslam_ros2)
  install(TARGETS plslam_ros2 RUNTIME DESTINATION bin COMPONENT ros2)
  install(FILES ${documents} DESTINATION share/doc/plslam-ros2 COMPONENT ros2)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/ros2/examples/ DESTINATION share/doc/plslam-ros2/examples COMPONENT ros2)
endif()

# --- component runtime: programs, their data, manual, completion, units, documents
install(TARGETS ${programs} RUNTIME DESTINATION bin COMPONENT runtime)
install(TARGETS plslam_odometry LIBRARY DESTINATION lib/plslam COMPONENT runtime)
install(DIRECTORY ${CMAKE_BINARY_DIR}/share/plslam/ DESTINATION share/plslam COMPONENT runtime)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/config/ DESTINATION share/plslam/config COMPONENT runtime
        FILES_MATCHING PATTERN "*.yaml")
install(DIRECTORY ${CMAKE_SOURCE_DIR}/lcmtypes/ DESTINATION share/plslam/lcmtypes COMPONENT runtime
        FILES_MATCHING PATTERN "*.lcm")
install(DIRECTORY ${CMAKE_BINARY_DIR}/share/man ${CMAKE_BINARY_DIR}/share/bash-completion ${CMAKE_BINARY_DIR}/share/zsh
                  ${CMAKE_BINARY_DIR}/share/fish
        DESTINATION share COMPONENT runtime)
install(DIRECTORY ${CMAKE_BINARY_DIR}/share/java DESTINATION share COMPONENT runtime OPTIONAL)
install(FILES ${CMAKE_SOURCE_DIR}/README.md ${CMAKE_SOURCE_DIR}/CHANGELOG.md ${CMAKE_SOURCE_DIR}/LICENSE
              ${CMAKE_SOURCE_DIR}/NOTICE ${CMAKE_SOURCE_DIR}/CITATION.cff
        DESTINATION share/doc/plslam COMPONENT runtime)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs DESTINATION share/doc/plslam COMPONENT runtime)
# The units contain the paths of the programs, which depend on the prefix.
install(CODE "set(PLSLAM_UNITS ${CMAKE_SOURCE_DIR}/scripts/systemd)" COMPONENT runtime)
install(SCRIPT ${CMAKE_SOURCE_DIR}/cmake/install_units.cmake COMPONENT runtime)

# --- component dev: find_package(plslam), targets plslam::core, plslam::geometry, ..., and the stages of SLAM without
# the bus: plslam::stereo, plslam::vo, plslam::mapping, plslam::loop
set(stages plslam_stereo plslam_vo plslam_mapping plslam_loop)
add_library(plslam_core INTERFACE)
target_link_libraries(plslam_core INTERFACE ${libraries} plslam_lcmtypes)
foreach(target ${libraries} ${stages} plslam_lcmtypes plslam_core)
  string(REPLACE "plslam_" "" exported ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${exported})
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:include/plslam>)
    target_compile_features(${target} PUBLIC cxx_std_20)
    # The same flags as in this tree, so that code in headers gives the same numbers.
    target_compile_options(${target} INTERFACE $<INSTALL_INTERFACE:-ffp-contract=off>)
  endif()
endforeach()
install(TARGETS ${libraries} ${stages} plslam_lcmtypes plslam_core EXPORT plslam_targets
        ARCHIVE DESTINATION lib/plslam COMPONENT dev)
install(EXPORT plslam_targets FILE plslam-targets.cmake NAMESPACE plslam:: DESTINATION lib/cmake/plslam COMPONENT dev)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/core ${CMAKE_SOURCE_DIR}/lcmtypes ${CMAKE_SOURCE_DIR}/vo_process
                  ${CMAKE_SOURCE_DIR}/mapping_process ${CMAKE_SOURCE_DIR}/loop_process
        DESTINATION include/plslam COMPONENT dev FILES_MATCHING PATTERN "*.h" PATTERN node EXCLUDE)
install(FILES ${CMAKE_SOURCE_DIR}/tools/odometry_library/plslam_odometry.h DESTINATION include COMPONENT dev)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/tools/examples/ DESTINATION share/doc/libplslam-dev/examples COMPONENT dev)
install(DIRECTORY ${CMAKE_BINARY_DIR}/lcmtypes/include/plslam DESTINATION include/plslam COMPONENT dev)
include(CMakePackageConfigHelpers)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/plslam-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_SOURCE_DIR}/cmake/plslam-config.cmake ${CMAKE_SOURCE_DIR}/cmake/plslam_core_dependencies.cmake
              ${CMAKE_BINARY_DIR}/plslam-config-version.cmake
        DESTINATION lib/cmake/plslam COMPONENT dev)

# --- component python: `import plslam`, where Debian's Python looks for packages
install(DIRECTORY ${CMAKE_BINARY_DIR}/python/plslam DESTINATION lib/python3/dist-packages COMPONENT python
        PATTERN __pycache__ EXCLUDE)
install(PROGRAMS ${CMAKE_SOURCE_DIR}/tools/python/examples/compute_odometry.py
                 ${CMAKE_SOURCE_DIR}/tools/python/examples/live_plot.py
                 ${CMAKE_SOURCE_DIR}/tools/python/examples/map_to_arrays.py
                 ${CMAKE_SOURCE_DIR}/tools/python/examples/to_ros2.py
        DESTINATION share/doc/python3-plslam/examples COMPONENT python)

include(plslam_package)
