plslam_benchmark(loop_benchmark SOURCES loop_benchmark.cpp LINK plslam_loop plslam_feature_world)
target_compile_definitions(loop_benchmark PRIVATE PLSLAM_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
