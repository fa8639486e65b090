plslam_test(vocabulary_fuzz_test
  SOURCES vocabulary_fuzz_test.cpp
  LINK plslam_allocation_counter plslam_places sodium::sodium LABEL fuzz)
