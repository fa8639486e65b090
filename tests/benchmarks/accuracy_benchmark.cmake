plslam_program(accuracy_benchmark SOURCES accuracy_benchmark.cpp
               LINK plslam_loop_run plslam_player plslam_config CLI11::CLI11)
target_compile_definitions(accuracy_benchmark PRIVATE PLSLAM_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
