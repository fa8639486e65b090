# SPDX-License-Identifier: BSD-3-Clause
# find_package(plslam): the libraries of core as plslam::core (all), or one by one (plslam::geometry, plslam::features,
# plslam::motion, plslam::map, plslam::optim, plslam::io, plslam::bus, plslam::lcmtypes, ...), and the stages of SLAM
# without the bus: plslam::vo (stereo odometry), plslam::mapping, plslam::loop.
#
#   find_package(plslam REQUIRED)
#   target_link_libraries(mine PRIVATE plslam::bus plslam::geometry)
#
#   #include "core/geometry/se3.h"
#   #include "plslam/pose_t.hpp"
include(${CMAKE_CURRENT_LIST_DIR}/plslam_core_dependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/plslam-targets.cmake)
