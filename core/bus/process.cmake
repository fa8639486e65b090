# Sources of the run loop (process.h), part of plslam_bus. They need plslam_config, CLI11::CLI11 and spdlog::spdlog.
set(plslam_process_sources process.cpp process_arguments.cpp process_main.cpp process_memory.cpp process_signals.cpp
    process_status.cpp process_usage.cpp)
