# SPDX-License-Identifier: BSD-3-Clause
# All dependencies of the tree.
include(plslam_core_dependencies)
# plslam calibrate.
find_package(Ceres 2.1 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_program(LCM_GEN lcm-gen REQUIRED)
