plslam_program(accuracy_benchmark SOURCES accuracy_benchmark.cpp
               LINK plslam_loop_run plslam_loop_node plslam_player plslam_config plslam_command_line CLI11::CLI11)
