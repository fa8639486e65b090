plslam_test(vocabulary_fuzz_test
  SOURCES vocabulary_fuzz_test.cpp ${CMAKE_SOURCE_DIR}/tests/unit/bus/allocation_counter.cpp
  LINK plslam_places sodium::sodium LABEL fuzz)
