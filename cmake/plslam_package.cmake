# SPDX-License-Identifier: BSD-3-Clause
# The target plslam_packages makes Debian packages in build/PRESET/packages: plslam, the programs and what they need, with
# dependencies found by dpkg-shlibdeps; libplslam-dev, the CMake package of core; and python3-plslam.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME plslam)
set(CPACK_PACKAGE_VENDOR "plslam")
# This address is not read. If you distribute packages, give your own: -D CPACK_PACKAGE_CONTACT="NAME <ADDRESS>".
set(CPACK_PACKAGE_CONTACT "the plslam authors <plslam@example.org>" CACHE STRING "Maintainer of the Debian packages")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "stereo visual SLAM with points and lines, as LCM processes")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL runtime dev python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME plslam)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
# lcm-logger, lcm-logplayer; the text of figures, with any font; lcm-spy with the jar of the types. Plug-ins of
# GStreamer: devices and formats for camera, H.264 for films; more formats, and GigE cameras.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS
    "liblcm-bin, fonts-dejavu-core, gstreamer1.0-plugins-base, gstreamer1.0-plugins-good, gstreamer1.0-plugins-ugly")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "liblcm-java, gstreamer1.0-libav, libaravis-0.8-0")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "Tracking, mapping, loop closing, a player of datasets, live cameras and a
viewer without display, as processes that talk over LCM.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libplslam-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "libeigen3-dev, libopencv-dev, libyaml-cpp-dev, libcli11-dev, libfmt-dev, libspdlog-dev, liblcm-dev, libpng-dev, libdeflate-dev, libjpeg-dev, libsodium-dev, liblz4-dev, libzstd-dev, libbz2-dev, libsqlite3-dev, zlib1g-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers, static libraries and the CMake package of plslam.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-plslam)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.9), python3-numpy")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Maps, runs, logs and live messages of plslam in Python, as arrays of numpy.")
if(TARGET dense_process)
  list(APPEND CPACK_COMPONENTS_ALL dense)
  set(CPACK_DEBIAN_DENSE_PACKAGE_NAME plslam-dense)
  set(CPACK_DEBIAN_DENSE_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_DENSE_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_DENSE_PACKAGE_DEPENDS "plslam (= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_DENSE_DESCRIPTION "Surfaces, OctoMap and grid for planning, from the images of a plslam run.")
endif()
if(TARGET plslam_bridge)
  list(APPEND CPACK_COMPONENTS_ALL bridge)
  set(CPACK_DEBIAN_BRIDGE_PACKAGE_NAME plslam-bridge)
  set(CPACK_DEBIAN_BRIDGE_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_BRIDGE_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_BRIDGE_PACKAGE_DEPENDS "plslam (= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_BRIDGE_DESCRIPTION "A running plslam, live in Foxglove and Lichtblick (plslam bridge).")
endif()
if(TARGET plslam_ros2)
  list(APPEND CPACK_COMPONENTS_ALL ros2)
  set(CPACK_DEBIAN_ROS2_PACKAGE_NAME plslam-ros2)
  set(CPACK_DEBIAN_ROS2_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_ROS2_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_ROS2_PACKAGE_DEPENDS "plslam (= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_ROS2_DESCRIPTION "plslam on a robot that speaks ROS 2, without anything of ROS (plslam_ros2).")
endif()
include(CPack)

add_custom_target(plslam_packages
  COMMAND ${CMAKE_CPACK_COMMAND} --config ${CMAKE_BINARY_DIR}/CPackConfig.cmake -B ${CMAKE_BINARY_DIR}/packages
  COMMENT "Making Debian packages in ${CMAKE_BINARY_DIR}/packages" VERBATIM)
add_dependencies(plslam_packages plslam_programs plslam_python plslam_lcmtypes ${libraries})
