plslam_test(dataset_fuzz_test SOURCES dataset_fuzz_test.cpp dataset_mutator.cpp
  LINK plslam_io plslam_dataset_folders fmt::fmt LABEL fuzz)
