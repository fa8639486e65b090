plslam_test(message_fuzz_test
  SOURCES message_fuzz_test.cpp
  LINK plslam_allocation_counter plslam_bus_test_support plslam_random_map LABEL fuzz)
