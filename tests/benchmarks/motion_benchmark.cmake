plslam_benchmark(motion_benchmark
  SOURCES motion_benchmark.cpp ../unit/motion/motion_world.cpp
  LINK plslam_motion)
