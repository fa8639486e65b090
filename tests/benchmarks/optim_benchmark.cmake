plslam_benchmark(optim_benchmark
  SOURCES optim_benchmark.cpp ../unit/optim/bundle_world.cpp
  LINK plslam_optim)
