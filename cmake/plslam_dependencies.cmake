# SPDX-License-Identifier: BSD-3-Clause
# Everything the tree links, found once.
include(plslam_core_dependencies)
# plslam calibrate.
find_package(Ceres 2.1 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_program(LCM_GEN lcm-gen REQUIRED)
