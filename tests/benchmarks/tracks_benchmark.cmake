plslam_program(tracks_benchmark SOURCES tracks_benchmark.cpp
               LINK plslam_odometry_run plslam_player plslam_config CLI11::CLI11)
