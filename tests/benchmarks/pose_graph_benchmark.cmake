plslam_benchmark(pose_graph_benchmark
  SOURCES pose_graph_benchmark.cpp ../unit/optim/pose_graph_world.cpp
  LINK plslam_optim plslam_stored_maps)
