plslam_program(relocalisation_benchmark SOURCES relocalisation_benchmark.cpp
               LINK plslam_loop_run plslam_loop_node plslam_player plslam_config plslam_command_line CLI11::CLI11)
