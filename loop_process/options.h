// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

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

/// Which keyframes may show the same place (PL-SLAM §VI.A.1).
struct CandidateOptions {
  /// Similarity to a candidate, relative to that with the keyframe before.
  double min_relative_score = 0.3;
  /// Landmarks that make two keyframes neighbours, which are no candidates, nor are their neighbours.
  int min_shared = 15;
  /// Newest keyframes of the session, no candidates.
  int recent_keyframes = 5;
  /// Best neighbours of a candidate whose similarities count with its own.
  int group_keyframes = 10;
  /// Most similar keyframes looked at.
  int max_queried = 20;
  /// Places that are verified, the most similar ones.
  int max_candidates = 3;
  /// Distance from which a loop was closed, a radian counting as two metres, above which it is measured again when
  /// the place is seen from half as far.
  double near_m = 1.0;
};

/// What a place must show to be believed (PL-SLAM §VI.A.2).
struct VerificationOptions {
  std::string gates = "default";
  /// Keyframes whose landmarks are the place.
  int local_keyframes = 8;
  /// Matches by descriptor (points + 2 x lines) worth a pose.
  int min_matches = 16;
  int min_inliers = 40;
  /// Inliers of the old keyframe among the landmarks of the new.
  int min_reverse_inliers = 25;
  /// Inliers with which a keyframe before the new one confirms the place.
  int min_neighbour_inliers = 25;
  /// Inliers that make up for one confirming keyframe; twice as many for two.
  int strong_inliers = 120;
  /// Inliers relative to the landmarks of the old keyframe that should be in view and features that could show them.
  double min_inlier_share = 0.15;
  /// The same where nothing connects the two keyframes, so that no drift tells.
  double min_inlier_share_unconnected = 0.4;
  /// Cells of a 4 x 4 grid over the image that must hold inliers.
  int min_cells = 5;
  /// Consecutive keyframes that must agree on the place, the new one included.
  int consistent_keyframes = 3;
  /// Largest eigenvalue of the covariance of the pose.
  double max_eigenvalue = 0.01;
  /// Difference of positions seen from both sides or by neighbours, relative to the distance of the landmarks.
  double max_disagreement = 0.05;
  /// The same of rotations.
  double max_disagreement_deg = 2.0;
  /// Sigma of drift along the shortest path through the map.
  double drift_per_m = 0.005;
  /// The same of rotation.
  double drift_deg_per_m = 0.02;
  /// Factor on the sigmas of the motions along that way.
  double covariance_scale = 5.0;
  /// Chi-square, 6 degrees of freedom, of a correction under that drift, above which a loop is not believed.
  double max_drift_chi2 = 25.0;
};

/// How a loop is closed in the pose graph (PL-SLAM §VI.B).
struct CorrectionOptions {
  /// Least sigma of a loop, all axes.
  double loop_sigma_m = 0.01;
  /// The same of rotation.
  double loop_sigma_deg = 0.1;
  MapDrift drift;
  PoseGraphOptions graph;
};

/// Adjustment of the whole map after a loop.
struct WholeMapOptions {
  bool enabled = true;
  /// Keyframes that see a landmark which takes part.
  int min_observations = 3;
  /// Points that take part, of each keyframe: those that most others see.
  int points_per_keyframe = 200;
  /// The same of lines.
  int lines_per_keyframe = 30;
  /// Sigma of the tracker's motion between keyframes, relative to what the tracker says of it.
  double relative_sigma = 1.0;
  BundleOptions bundle;

  WholeMapOptions() {
    bundle.max_iterations = 20;
    bundle.function_tolerance = 1e-3;
  }
};

/// When a camera of which nothing is known is found in the map.
struct RelocalisationOptions {
  /// Most similar keyframes looked at.
  int max_queried = 40;
  /// Places that are verified, the most similar ones.
  int max_candidates = 8;
  int min_inliers = 50;
  /// As in `VerificationOptions`.
  double min_inlier_share = 0.3;
  /// Inliers of another pose elsewhere, relative to the best, above which neither is believed.
  double max_rival_share = 0.5;
};

/// Everything of loop_process.
struct LoopOptions {
  bool enabled = true;
  VocabularyOptions vocabularies;
  PlaceOptions places;
  CandidateOptions candidates;
  LocalisationOptions localisation;
  VerificationOptions verification;
  CorrectionOptions correction;
  WholeMapOptions adjustment;
  RelocalisationOptions relocalisation;
};

template <class Visitor>
void VisitFields(Visitor& visit, VocabularyOptions& o) {
  visit("points", o.points, "vocabulary of points: a path, or a file that comes with the programs");
  visit("lines", o.lines, "the same of lines");
}

template <class Visitor>
void VisitFields(Visitor& visit, VerificationOptions& o) {
  visit("gates", o.gates, OneOf{"default", "paper"},
        "default, or the paper's three tests: eigenvalues of the covariance below 0.01, at most 0.50 m and 3.00 deg "
        "apart, more than half of the matches inliers");
  visit("min_inliers", o.min_inliers, Bounds{3, 10000}, "inliers (points + 2 x lines) of the keyframe in the place");
}

template <class Visitor>
void VisitFields(Visitor& visit, WholeMapOptions& o) {
  visit("enabled", o.enabled, "adjust the whole map after each loop");
  visit("bundle", o.bundle, "bundle adjustment");
}

template <class Visitor>
void VisitFields(Visitor& visit, RelocalisationOptions& o) {
  visit("min_inliers", o.min_inliers, Bounds{3, 10000}, "inliers (points + 2 x lines) of the frame in the place");
}

template <class Visitor>
void VisitFields(Visitor& visit, LoopOptions& o) {
  visit("enabled", o.enabled, "look for loops");
  visit("vocabularies", o.vocabularies, "words that places are described by");
  visit("places", o.places, "how similar two places look");
  visit("verification", o.verification, "what a place must show to be believed");
  visit("adjustment", o.adjustment, "adjustment of the whole map after a loop");
  visit("relocalisation", o.relocalisation, "where a camera is of which nothing is known");
}

}  // namespace plslam::loop
