// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/row_format.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "core/errors/error_text.h"
#include "core/files/text_rows.h"
#include "core/io/trajectories/table_header.h"

namespace plslam {
namespace {

constexpr RowLayout kTumLayout{"the TUM format", TrajectoryFormat::kTum, 9, {4, 5, 6, 7}};
constexpr RowLayout kEurocLayout{"the EuRoC format", TrajectoryFormat::kEuroc, 0, {5, 6, 7, 4}, true};
constexpr RowLayout kVslamLabLayout{"the VSLAM-LAB format", TrajectoryFormat::kVslamLab, 0, {4, 5, 6, 7}};

constexpr double kMinStep_ns = 1e5, kMaxStep_ns = 1e10;
/// Poses of keyframes, say, whose unit is stated.
constexpr double kMaxStatedStep_ns = 1e12;
constexpr size_t kMostSampled = 1000;
constexpr size_t kLeastForSteps = 3;

/// The first rows of a file.
struct Sample {
  size_t n_rows = 0;
  bool has_commas = false;
  size_t n_fields = 0;  ///< of the first row that can be of a pose
  std::string first_error;
  std::string first_place, first_time;
  std::vector<double> times;
};

/// Thrown to leave a file.
struct EnoughRows {};

Sample ReadSample(const std::string& path, const std::optional<TableHeader>& header) {
  Sample sample;
  const size_t time = header ? header->time : 0;
  try {
    ForEachRow(path, [&](const TextRow& row) {
      if (row.IsCsvHeader() || (header && row.line == header->line)) return;
      if (sample.n_rows++ == kMostSampled) throw EnoughRows();
      if (row.fields.size() <= time) return;
      if (sample.first_place.empty()) {
        sample.first_place = fmt::format("{}:{}", path, row.line);
        sample.first_time = row.fields[time];
        sample.first_error = fmt::format(
            "{}: {} numbers fit none of the formats TUM (8), KITTI (12) and EuRoC (8 or more, with commas)",
            sample.first_place, row.fields.size());
      }
      const size_t n = row.fields.size();
      if (sample.n_fields == 0 && (row.has_commas || n == 8 || n == 12 || header)) {
        sample.n_fields = n;
        sample.has_commas = row.has_commas;
      }
      try {
        sample.times.push_back(row.Number(time));
      } catch (const std::runtime_error&) {
        return;  // a row that is no pose
      }
    });
  } catch (const EnoughRows&) {
    return sample;
  }
  return sample;
}

/// Steps and size of the times, in their own unit.
struct TimeScale {
  double step = 0.0;  ///< the median; 0: there are too few
  double largest = 0.0;
};

TimeScale ScaleOf(const std::vector<double>& times) {
  TimeScale scale;
  std::vector<double> steps;
  for (size_t i = 0; i < times.size(); ++i) {
    scale.largest = std::max(scale.largest, std::abs(times[i]));
    const double step = i == 0 ? 0.0 : std::abs(times[i] - times[i - 1]);
    if (step > 0.0) steps.push_back(step);
  }
  if (steps.size() + 1 < kLeastForSteps) return scale;
  const auto middle = steps.begin() + std::ssize(steps) / 2;
  std::nth_element(steps.begin(), middle, steps.end());
  scale.step = *middle;
  return scale;
}

/// Returns whether times can be in units of 10^`decimals` ns.
bool CanBe(const TimeScale& scale, int decimals, double max_step_ns = kMaxStep_ns) {
  const double unit_ns = std::pow(10.0, decimals);
  return scale.step * unit_ns >= kMinStep_ns && scale.step * unit_ns <= max_step_ns &&
         scale.largest * unit_ns <= static_cast<double>(kMaxTime_ns);
}

/// Returns whether times are of our century if they are in units of 10^`decimals` ns.
bool AreOfOurTime(const TimeScale& scale, int decimals) {
  const double first = 1e18 / std::pow(10.0, decimals);
  return scale.largest >= first && scale.largest <= 4.6 * first;
}

/// Returns the unit of one or two times, which is seconds or nanoseconds: a point, or the ten digits of a second of our
/// time. Nanoseconds of a clock that starts at 0 have ten digits for some seconds, too, and are a day apart as seconds.
int DecimalsOfFew(const Sample& sample) {
  constexpr double kFirstNs = 1e11, kDay_s = 86'400.0;
  const std::string& text = sample.first_time;
  const std::vector<double>& times = sample.times;
  if (times.empty()) return 0;
  if (text.find_first_of(".eE") != text.npos) return std::abs(times[0]) < kFirstNs ? 9 : 0;
  const bool ten_digits = sample.n_fields == kTumLayout.n_fields && text.size() == 10 &&
                          text.find_first_not_of("0123456789") == text.npos;
  const bool is_far = times.size() > 1 && std::abs(times[1] - times[0]) > kDay_s;
  return ten_digits && times[0] * 1e9 <= static_cast<double>(kMaxTime_ns) && !is_far ? 9 : 0;
}

/// Returns the unit of the times of rows with commas.
int InferDecimals(const std::string& path, const Sample& sample, bool has_order) {
  const TimeScale scale = ScaleOf(sample.times);
  if (scale.step == 0.0) return DecimalsOfFew(sample);
  for (const int decimals : {3, 6}) {
    if (!AreOfOurTime(scale, decimals) || !CanBe(scale, decimals)) continue;
    if (has_order) return decimals;
    throw std::runtime_error(
        fmt::format("{}: times like {} seem to be in {}, and neither in the nanoseconds of EuRoC nor in the seconds "
                    "of TUM: name their unit "
                    "and the order of the quaternion in a first line, as in timestamp [{}],tx,ty,tz,qx,qy,qz,qw",
                    path, Shown(sample.first_time), UnitOfTimeName(decimals), decimals == 3 ? "us" : "ms"));
  }
  for (const int decimals : {0, 9}) {
    if (CanBe(scale, decimals)) return decimals;
  }
  const int likely = LikelyUnitOfStep(scale.step);
  throw std::runtime_error(
      fmt::format("{}: times are in nanoseconds (EuRoC) or seconds (TUM) in rows with commas, and so its poses would "
                  "be {:g} s or {:g} s "
                  "apart in the median, not 0.0001 to 10 s; are they in {}? Name the unit in a first line, as in "
                  "timestamp [ms],tx,ty,"
                  "tz,qx,qy,qz,qw",
                  path, 1e-9 * scale.step, scale.step, UnitOfTimeName(likely)));
}

void CheckStatedUnit(const std::string& path, const Sample& sample, const TableHeader& header) {
  const TimeScale scale = ScaleOf(sample.times);
  const int decimals = *header.time_decimals;
  if (scale.step == 0.0 || CanBe(scale, decimals, kMaxStatedStep_ns)) return;
  const int likely = LikelyUnitOfStep(scale.step);
  throw std::runtime_error(
      fmt::format("{}:{}: the column '{}' is in {} by its name, and so times like {} would be {:g} s apart in the "
                  "median, not 0.0001 to "
                  "1000 s{}: correct the name",
                  path, header.line, Shown(header.time_name), UnitOfTimeName(decimals), Shown(sample.first_time),
                  1e-9 * std::pow(10.0, decimals) * scale.step,
                  likely == decimals ? "" : fmt::format("; are they in {}?", UnitOfTimeName(likely))));
}

/// The layout of a header that names a quaternion.
void SetColumns(const TableHeader& header, RowLayout* layout) {
  layout->time = header.time;
  layout->quaternion = *header.quaternion;
  if (header.position) layout->position = *header.position;
  size_t last = header.time;
  for (const size_t column : layout->quaternion) last = std::max(last, column);
  for (const size_t column : layout->position) last = std::max(last, column);
  // The first eight columns are those of all formats, whatever follows.
  if (last >= layout->n_fields) {
    layout->n_fields = header.n_columns;
    layout->name = "this file, by its header,";
  }
  layout->may_be_longer |= header.n_columns > layout->n_fields || layout->n_fields > kTumLayout.n_fields;
}

}  // namespace

std::optional<RowFormat> FindRowFormat(const std::string& path, std::optional<TrajectoryFormat> format,
                                       Notes* notes) {
  if (format == TrajectoryFormat::kKitti) return RowFormat{};
  std::optional<TableHeader> header = ReadTableHeader(path);
  if (header && !header->quaternion && header->time != 0) header.reset();
  const Sample sample = ReadSample(path, header);
  if (sample.n_rows == 0) return std::nullopt;
  const bool has_order = header && header->quaternion;
  if (!format && !has_order && !sample.has_commas) {
    if (sample.n_fields == 12) return RowFormat{};
    if (sample.n_fields != 8) throw std::runtime_error(sample.first_error);
  }
  const bool is_euroc = format == TrajectoryFormat::kEuroc || (!format && sample.has_commas);
  RowLayout layout = is_euroc ? kEurocLayout : format == TrajectoryFormat::kVslamLab ? kVslamLabLayout : kTumLayout;
  if (header && header->time_decimals) {
    CheckStatedUnit(path, sample, *header);
    layout.time_decimals = *header->time_decimals;
  } else if (layout.format != TrajectoryFormat::kTum) {
    layout.time_decimals = InferDecimals(path, sample, has_order);
  }
  if (has_order) {
    SetColumns(*header, &layout);
  } else if (is_euroc && layout.time_decimals != 0) {
    if (sample.n_fields != kTumLayout.n_fields) {
      throw std::runtime_error(
          fmt::format("{}: time '{}' is in {}, but in nanoseconds in the EuRoC format: name the columns in a first "
                      "line, as in timestamp "
                      "[s],tx,ty,tz,qx,qy,qz,qw",
                      sample.first_place, Shown(sample.first_time), UnitOfTimeName(layout.time_decimals)));
    }
    const int decimals = layout.time_decimals;
    layout = kTumLayout;
    layout.time_decimals = decimals;
    notes->Remark(fmt::format("{}: times of rows with commas are in {}: read as TUM's t,tx,ty,tz,qx,qy,qz,qw", path,
                              UnitOfTimeName(decimals)));
  }
  return RowFormat{layout, header ? header->line : 0};
}

}  // namespace plslam
