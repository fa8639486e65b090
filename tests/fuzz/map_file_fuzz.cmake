plslam_test(map_file_fuzz_test
  SOURCES map_file_fuzz_test.cpp
  LINK plslam_allocation_counter plslam_stored_maps LABEL fuzz)
