plslam_test(message_fuzz_test
  SOURCES message_fuzz_test.cpp ${CMAKE_SOURCE_DIR}/tests/unit/bus/allocation_counter.cpp
  LINK plslam_bus_test_support plslam_random_map LABEL fuzz)
