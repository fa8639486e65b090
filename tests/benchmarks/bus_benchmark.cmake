plslam_benchmark(bus_benchmark SOURCES bus_benchmark.cpp LINK plslam_bus)
