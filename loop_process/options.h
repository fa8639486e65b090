// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "core/config/choices.h"
#include "core/config/fields.h"
#include "core/localisation/options.h"
#include "core/optim/bundle/options.h"
#include "core/optim/pose_graph/map_pose_graph.h"
#include "core/places/options.h"

namespace plslam::loop {

/// Files of the vocabularies.
struct VocabularyOptions {
  std::string points = "orb.vocabulary";
  std::string lines = "lbd.vocabulary";
};

/// Selection of keyframes that may show the same place (PL-SLAM §VI.A.1).
struct CandidateOptions {
  /// Least similarity of a candidate, relative to that of the previous keyframe.
  double min_relative_score = 0.3;
  /// Shared landmarks that make two keyframes neighbours; neighbours and their neighbours are no candidates.
  int min_shared = 15;
  /// Newest keyframes of the session that are no candidates.
  int recent_keyframes = 5;
  /// Best neighbours of a candidate whose similarities are added to its own.
  int group_keyframes = 10;
  /// Most similar keyframes returned by the index of places.
  int max_queried = 20;
  /// Most similar places that are verified.
  int max_candidates = 3;
  /// Distance above which a loop is measured again once the place is seen from half as far; a radian counts as two
  /// metres.
  double near_m = 1.0;
};

/// Tests of a loop candidate: those of this project, or the paper's three.
enum class LoopGates { kDefault, kPaper };
constexpr auto ChoicesOf(LoopGates) {
  return std::array{Choice{"default", LoopGates::kDefault}, Choice{"paper", LoopGates::kPaper}};
}

/// Tests that a loop candidate must pass (PL-SLAM §VI.A.2).
struct VerificationOptions {
  LoopGates gates = LoopGates::kDefault;
  /// Keyframes whose landmarks form the place.
  int local_keyframes = 8;
  /// Least matches by descriptor (points + 2 x lines) for a pose.
  int min_matches = 16;
  int min_inliers = 40;
  /// Inliers of the old keyframe among the landmarks of the new one.
  int min_reverse_inliers = 25;
  /// Inliers with which a previous keyframe confirms the place.
  int min_neighbour_inliers = 25;
  /// Inliers that replace one confirming keyframe; twice as many replace two.
  int strong_inliers = 120;
  /// Inliers relative to the landmarks of the old keyframe that should be visible and matched.
  double min_inlier_share = 0.15;
  /// The same without a path between the two keyframes, when drift cannot be checked.
  double min_inlier_share_unconnected = 0.4;
  /// Cells of a 4 x 4 grid over the image that must hold inliers.
  int min_cells = 5;
  /// Consecutive keyframes that must agree on the place, including the new one.
  int consistent_keyframes = 3;
  /// Largest eigenvalue of the covariance of the pose.
  double max_eigenvalue = 0.01;
  /// Difference of positions measured from both sides or by neighbours, relative to the distance of the landmarks.
  double max_disagreement = 0.05;
  /// The same of rotations.
  double max_disagreement_deg = 2.0;
  /// Sigma of drift along the shortest path through the map.
  double drift_per_m = 0.005;
  /// The same of rotation.
  double drift_deg_per_m = 0.02;
  /// Factor on the sigmas of the motions along that path.
  double covariance_scale = 5.0;
  /// Gate of the chi-square, 6 degrees of freedom, of a correction under that drift.
  double max_drift_chi2 = 25.0;
};

/// Correction of a loop in the pose graph (PL-SLAM §VI.B).
struct CorrectionOptions {
  /// Smallest sigma of a loop, all axes.
  double loop_sigma_m = 0.01;
  /// The same of rotation.
  double loop_sigma_deg = 0.1;
  MapDrift drift;
  PoseGraphOptions graph;
};

/// Global bundle adjustment after a loop.
struct GlobalBundleOptions {
  bool enabled = true;
  /// Keyframes that must see a landmark which takes part.
  int min_observations = 3;
  /// Points that take part, for each keyframe: those seen by most keyframes.
  int points_per_keyframe = 200;
  /// The same of lines.
  int lines_per_keyframe = 30;
  /// Sigma of the tracker's motion between keyframes, relative to the published one.
  double relative_sigma = 1.0;
  BundleOptions bundle;

  GlobalBundleOptions() {
    bundle.max_iterations = 20;
    bundle.function_tolerance = 1e-3;
  }
};

/// Acceptance of the pose of a camera without a prior.
struct RelocalisationOptions {
  /// Most similar keyframes returned by the index of places.
  int max_queried = 40;
  /// Most similar places that are verified.
  int max_candidates = 8;
  int min_inliers = 50;
  /// As in `VerificationOptions`.
  double min_inlier_share = 0.3;
  /// Inliers of a pose elsewhere, relative to the best one, above which both are rejected.
  double max_rival_share = 0.5;
};

/// All options of loop_process.
struct LoopOptions {
  bool enabled = true;
  VocabularyOptions vocabularies;
  PlaceOptions places;
  CandidateOptions candidates;
  LocalisationOptions localisation;
  VerificationOptions verification;
  CorrectionOptions correction;
  GlobalBundleOptions adjustment;
  RelocalisationOptions relocalisation;
};

template <class Visitor>
void VisitFields(Visitor& visit, VocabularyOptions& o) {
  visit("points", o.points, "vocabulary of points: a path, or a file installed with the programs");
  visit("lines", o.lines, "vocabulary of lines, likewise");
}

template <class Visitor>
void VisitFields(Visitor& visit, VerificationOptions& o) {
  visit("gates", o.gates,
        "default, or the paper's three tests: eigenvalues of the covariance below 0.01, at most 0.50 m and 3.00 deg "
        "apart, more than half of the matches inliers");
  visit("min_inliers", o.min_inliers, Bounds{3, 10000}, "inliers (points + 2 x lines) required for a loop");
}

template <class Visitor>
void VisitFields(Visitor& visit, GlobalBundleOptions& o) {
  visit("enabled", o.enabled, "global bundle adjustment after loops that may improve the map");
  visit("bundle", o.bundle, "bundle adjustment");
}

template <class Visitor>
void VisitFields(Visitor& visit, RelocalisationOptions& o) {
  visit("min_inliers", o.min_inliers, Bounds{3, 10000}, "inliers (points + 2 x lines) required for a relocalisation");
}

template <class Visitor>
void VisitFields(Visitor& visit, LoopOptions& o) {
  visit("enabled", o.enabled, "detect loops");
  visit("vocabularies", o.vocabularies, "visual vocabularies");
  visit("places", o.places, "similarity of places");
  visit("verification", o.verification, "verification of loop candidates");
  visit("adjustment", o.adjustment, "global bundle adjustment after a loop");
  visit("relocalisation", o.relocalisation, "relocalisation of lost cameras");
}

}  // namespace plslam::loop
