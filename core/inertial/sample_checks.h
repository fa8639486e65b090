// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include <Eigen/Core>

#include "core/geometry/imu.h"

namespace plslam {

/// Properties of an inertial sensor that its samples alone show: rate, gaps, noise, and values that repeat. Noise, force
/// and the share of values at an end of the range are those of about the last ten seconds.
class SampleChecks {
 public:
  /// Longest interval between samples that is no gap: `Preintegrate` interpolates it.
  static constexpr double kLongestInterval_s = 0.15;
  static constexpr double kMemory_s = 10.0;

  /// Takes the next sample; those that are not later than one before are ignored.
  void Add(const ImuSample& sample);

  /// Samples a second, by the median of the last intervals; 0 before there are some.
  double Rate_hz() const;
  int n_gaps() const { return n_gaps_; }
  double longest_gap_s() const { return longest_gap_s_; }
  /// Time for which the newest sample's rates, and forces, have repeated, if they did so for many samples.
  double RatesStuck_s() const { return Stuck_s(0); }
  double ForcesStuck_s() const { return Stuck_s(3); }
  /// White noise densities by the scatter of the samples about their neighbours' polynomial, the largest of the axes:
  /// rad/s/sqrt(Hz) and m/s^2/sqrt(Hz).
  double RateNoise() const { return Noise(0); }
  double ForceNoise() const { return Noise(3); }
  /// The bound at which many samples of a channel end, the number of samples there, and their share of ten seconds.
  struct Saturation {
    bool of_rate = true;
    int axis = 0;
    double bound = 0.0;
    int n_samples = 0;
    double share = 0.0;
  };
  /// The channel with the largest share of such samples; none has `n_samples` 0.
  Saturation MostSaturated() const;
  /// Samples at such bounds, of all channels.
  int n_saturated() const;
  /// Mean norm of the specific force, whose vibrations are averaged over a quarter of a second, m/s^2; 0 before that.
  double Force_m_s2() const { return force_m_s2_; }

  /// The state, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.newest_, self.intervals_s_, self.n_gaps_, self.longest_gap_s_, self.weight_, self.block_force_,
      self.block_s_, self.n_blocks_, self.force_m_s2_, self.n_scatter_, self.scatter2_, self.mean_, self.run_,
      self.run_s_, self.most_, self.least_, self.n_most_, self.n_least_, self.most_weight_, self.least_weight_);
  }

 private:
  static constexpr int kChannels = 6;
  using Channels = Eigen::Matrix<double, kChannels, 1>;
  struct Value {
    int64_t t_ns = 0;
    Channels values = Channels::Zero();

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.t_ns, self.values);
    }
  };

  void AddForce(const Eigen::Vector3d& force_m_s2, double dt_s);
  void CountInterval(double dt_s);
  void CountRuns(const Value& sample, double dt_s);
  void AddScatter(double kept);
  template <class Visitor>
  void ForEachSaturation(const Visitor& visit) const;
  double Stuck_s(int first) const;
  double Noise(int first) const;
  double NoiseOfSample(int channel) const;

  double weight_ = 0.0;  ///< number of samples; like all sums, of those in memory
  std::deque<Value> newest_;
  std::deque<double> intervals_s_;
  int n_gaps_ = 0;
  double longest_gap_s_ = 0.0;
  /// Integral of the force over the present block, and its time; the mean norm of the means of earlier ones.
  Eigen::Vector3d block_force_ = Eigen::Vector3d::Zero();
  double block_s_ = 0.0;
  int64_t n_blocks_ = 0;
  double force_m_s2_ = 0.0;
  double n_scatter_ = 0.0;
  Channels scatter2_ = Channels::Zero();  ///< sums of squares of fourth differences
  Channels mean_ = Channels::Zero();
  /// Number of equal values up to the newest one, and the time that they cover.
  std::array<int, kChannels> run_{};
  Channels run_s_ = Channels::Zero();
  /// The extreme values, and how many samples are equal to them in runs.
  Channels most_ = Channels::Zero();
  Channels least_ = Channels::Zero();
  std::array<int, kChannels> n_most_{};
  std::array<int, kChannels> n_least_{};
  /// The numbers of those in memory.
  Channels most_weight_ = Channels::Zero();
  Channels least_weight_ = Channels::Zero();
};

}  // namespace plslam
