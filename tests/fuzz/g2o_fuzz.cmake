plslam_test(g2o_fuzz_test SOURCES g2o_fuzz_test.cpp
  LINK plslam_pose_graph_tool plslam_dataset_folders LABEL fuzz)
