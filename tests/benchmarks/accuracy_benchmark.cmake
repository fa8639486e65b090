plslam_program(accuracy_benchmark SOURCES accuracy_benchmark.cpp
               LINK plslam_odometry_run plslam_player plslam_config CLI11::CLI11)
