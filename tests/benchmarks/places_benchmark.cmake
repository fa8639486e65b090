plslam_benchmark(places_benchmark
  SOURCES places_benchmark.cpp
  LINK plslam_places plslam_evaluate_plot plslam_opencv opencv_core opencv_imgproc plslam_io fmt::fmt)
