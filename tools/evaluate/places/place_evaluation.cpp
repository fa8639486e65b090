// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/place_evaluation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/config/fields.h"

namespace plslam::evaluate {
namespace {

/// The true class of each pair (later frame, earlier frame), row by row.
class TruthTable {
 public:
  TruthTable(const std::vector<PlaceFrame>& frames, const RevisitOptions& options) : size_(frames.size()) {
    truth_.resize(size_ * size_, PairTruth::kIgnored);
    for (size_t i = 0; i < size_; ++i) {
      for (size_t j = 0; j < i; ++j) truth_[i * size_ + j] = ClassifyPair(frames[i].pose, frames[j].pose, options);
    }
  }

  PairTruth At(size_t later, size_t earlier) const { return truth_[later * size_ + earlier]; }
  int Count(PairTruth what) const { return static_cast<int>(std::count(truth_.begin(), truth_.end(), what)); }
  bool Revisits(size_t later) const {
    const auto row = truth_.begin() + static_cast<std::ptrdiff_t>(later * size_);
    return std::find(row, row + static_cast<std::ptrdiff_t>(size_), PairTruth::kRevisit) !=
           row + static_cast<std::ptrdiff_t>(size_);
  }
  int RevisitingFrames() const {
    int count = 0;
    for (size_t i = 0; i < size_; ++i) count += Revisits(i) ? 1 : 0;
    return count;
  }

 private:
  size_t size_;
  std::vector<PairTruth> truth_;
};

PlaceRecogniser RecogniserFor(const Vocabulary& points, const Vocabulary& lines, Merge merge) {
  PlaceOptions options;
  options.merge = merge;
  return {points, lines, options};
}

std::vector<ScoredProposal> BestMatches(const std::vector<PlaceFrame>& frames, const TruthTable& truth,
                                        PlaceRecogniser recogniser) {
  std::vector<ScoredProposal> proposals;
  for (size_t i = 0; i < frames.size(); ++i) {
    const auto ignored = [&](KeyframeId j) {
      return truth.At(i, static_cast<size_t>(j.value)) == PairTruth::kIgnored;
    };
    for (const PlaceMatch& match : recogniser.Query(frames[i].description, ignored, 1)) {
      const PairTruth what = truth.At(i, static_cast<size_t>(match.keyframe_id.value));
      proposals.push_back({match.score, what == PairTruth::kRevisit});
    }
    recogniser.Add(KeyframeId(i), frames[i].description);
  }
  return proposals;
}

std::vector<ScoredProposal> AllPairs(const std::vector<PlaceFrame>& frames, const TruthTable& truth,
                                     PlaceRecogniser recogniser) {
  std::vector<ScoredProposal> proposals;
  for (size_t i = 0; i < frames.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const PairTruth what = truth.At(i, j);
      if (what == PairTruth::kIgnored) continue;
      proposals.push_back(
          {recogniser.Score(frames[i].description, frames[j].description), what == PairTruth::kRevisit});
    }
    recogniser.Add(KeyframeId(i), frames[i].description);
  }
  return proposals;
}

SimilarityMatrix MatrixOf(const std::vector<PlaceFrame>& frames, PlaceRecogniser recogniser) {
  SimilarityMatrix matrix;
  for (const PlaceFrame& frame : frames) recogniser.Add(KeyframeId(recogniser.size()), frame.description);
  matrix.size = static_cast<int>(frames.size());
  for (const PlaceFrame& row : frames) {
    for (const PlaceFrame& column : frames) {
      matrix.values.push_back(static_cast<float>(recogniser.Score(row.description, column.description)));
    }
  }
  return matrix;
}

}  // namespace

PairTruth ClassifyPair(const TimedPose& a, const TimedPose& b, const RevisitOptions& options) {
  const double gap_s = 1e-9 * std::abs(static_cast<double>(a.t_ns - b.t_ns));
  if (gap_s < options.min_gap_s) return PairTruth::kIgnored;
  const double distance_m = (a.T_w_c.translation() - b.T_w_c.translation()).norm();
  const double angle_deg = a.T_w_c.rotation().angularDistance(b.T_w_c.rotation()) * 180.0 / std::numbers::pi;
  if (distance_m <= options.distance_m && angle_deg <= options.angle_deg) return PairTruth::kRevisit;
  const bool far = distance_m > options.far_distance_m || angle_deg > options.far_angle_deg;
  return far ? PairTruth::kOtherPlace : PairTruth::kIgnored;
}

PrecisionRecall ComputePrecisionRecall(std::vector<ScoredProposal> proposals, int positives) {
  PrecisionRecall result;
  if (positives <= 0) return result;
  std::sort(proposals.begin(), proposals.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  int right = 0;
  int wrong = 0;
  double recall_before = 0.0;
  for (size_t i = 0; i < proposals.size();) {
    const double score = proposals[i].score;
    for (; i < proposals.size() && proposals[i].score == score; ++i) ++(proposals[i].right ? right : wrong);
    const double precision = 1.0 * right / (right + wrong);
    const double recall = 1.0 * right / positives;
    result.curve.push_back({score, precision, recall});
    result.area += precision * (recall - recall_before);
    recall_before = recall;
    if (wrong == 0) result.recall_at_full_precision = recall;
  }
  return result;
}

PlaceEvaluation EvaluatePlaces(const std::string& name, const std::vector<PlaceFrame>& frames,
                               const Vocabulary& points, const Vocabulary& lines, const RevisitOptions& options) {
  const TruthTable truth(frames, options);
  PlaceEvaluation result;
  result.name = name;
  result.frames = static_cast<int>(frames.size());
  result.revisiting_frames = truth.RevisitingFrames();
  result.revisits = truth.Count(PairTruth::kRevisit);
  result.other_places = truth.Count(PairTruth::kOtherPlace);
  for (const auto& [name_of_merge, merge] : ChoicesOf(Merge())) {
    const PlaceRecogniser recogniser = RecogniserFor(points, lines, merge);
    result.merges.push_back({merge,
                             ComputePrecisionRecall(BestMatches(frames, truth, recogniser), result.revisiting_frames),
                             ComputePrecisionRecall(AllPairs(frames, truth, recogniser), result.revisits)});
  }
  result.similarities.points = MatrixOf(frames, RecogniserFor(points, lines, Merge::kPoints));
  result.similarities.lines = MatrixOf(frames, RecogniserFor(points, lines, Merge::kLines));
  result.similarities.merged = MatrixOf(frames, RecogniserFor(points, lines, PlaceOptions().merge));
  return result;
}

}  // namespace plslam::evaluate
