plslam_program(tracks_benchmark SOURCES tracks_benchmark.cpp
               LINK plslam_odometry_run plslam_player plslam_config plslam_command_line CLI11::CLI11)
