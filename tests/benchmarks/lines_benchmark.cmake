plslam_benchmark(lines_benchmark SOURCES lines_benchmark.cpp
  LINK plslam_features plslam_geometry opencv_core opencv_imgproc plslam_io)
