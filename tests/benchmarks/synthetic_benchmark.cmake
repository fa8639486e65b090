plslam_benchmark(synthetic_benchmark
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/synthetic_benchmark.cpp
  LINK plslam_synthetic benchmark::benchmark_main)
