plslam_benchmark(features_benchmark
  SOURCES features_benchmark.cpp
  LINK plslam_features plslam_io)
