// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// One status of a process.
struct ProcessSample {
  std::string process;
  std::string state;
  double t_s = 0.0;       ///< by the listener's clock
  FrameId frame_id = -1;  ///< newest frame at that time
  double cpu_s = 0.0;
  double memory_mb = 0.0;
  std::vector<std::pair<std::string, double>> counters;
  int64_t pid = 0;
  double queue = 0.0;       ///< length of its longest queue
  int64_t lag_frames = -1;  ///< as ReportNode counts it; -1: it has none
  int64_t sent_frames = 0;  ///< by the player then
  double uptime_s = 0.0;    ///< by the clock of the process
};

/// Stores queues, repairs, times and memory of each process over the run, in bounded memory: at most 16 processes, 32
/// counters each (queues, and the bus's lost, repaired, resent, rejected and skipped messages), and 600 samples, of
/// which every second one is dropped when there are more. Non-finite numbers are rejected.
class ProcessLog {
 public:
  void Add(const ProcessSample& sample);
  std::vector<ReportProcess> Processes() const;

 private:
  struct Series {
    std::string state;
    int64_t pid = 0;
    int64_t restarts = 0;
    double heard_s = 0.0;
    double queue = 0.0;
    int64_t lag_frames = -1;
    int64_t sent_frames = 0;
    std::vector<float> t_s;
    std::vector<float> uptime_s;
    std::vector<int32_t> frame;
    std::vector<float> cpu_s;
    std::vector<float> memory_mb;
    /// One number for each sample; NaN where the status did not have it.
    std::map<std::string, std::vector<float>> counters;
    int64_t every = 1;
    int64_t heard = 0;
  };

  static void Append(const ProcessSample& sample, Series& series);
  static void Halve(Series& series);

  std::map<std::string, Series> processes_;
  double first_t_s_ = 0.0;
};

}  // namespace plslam::viewer
