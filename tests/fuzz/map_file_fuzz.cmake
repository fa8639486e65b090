plslam_test(map_file_fuzz_test
  SOURCES map_file_fuzz_test.cpp ${CMAKE_SOURCE_DIR}/tests/unit/bus/allocation_counter.cpp
  LINK plslam_stored_maps LABEL fuzz)
