#pragma once

#include <string>

#include "core/config/fields.h"
#include "core/localisation/options.h"
#include "core/optim/bundle/options.h"
#include "core/optim/pose_graph/map_pose_graph.h"
#include "core/places/options.h"

namespace plslam {

/// Files of the vocabularies.
struct VocabularyOptions {
  std::string points = "orb.vocabulary";
  std::string lines = "lbd.vocabulary";
};

/// Which keyframes may show the same place (PL-SLAM §VI.A.1).
struct CandidateOptions {
  double min_relative_score = 0.3;
  int min_shared = 15;
  int recent_keyframes = 5;
  int group_keyframes = 10;
  int max_queried = 20;
  int max_candidates = 3;
  double near_m = 1.0;
};

/// What a place must show to be believed (PL-SLAM §VI.A.2).
struct VerificationOptions {
  std::string gates = "default";
  int local_keyframes = 8;
  int min_matches = 16;
  int min_inliers = 40;
  int min_reverse_inliers = 25;
  int min_neighbour_inliers = 25;
  int strong_inliers = 120;
  double min_inlier_share = 0.15;
  double min_inlier_share_unconnected = 0.4;
  int min_cells = 5;
  int consistent_keyframes = 3;
  double max_eigenvalue = 0.01;
  double max_disagreement = 0.05;
  double max_disagreement_deg = 2.0;
  double drift_per_m = 0.005;
  double drift_deg_per_m = 0.02;
  double covariance_scale = 5.0;
  double max_drift_chi2 = 25.0;
};

/// How a loop is closed in the pose graph (PL-SLAM §VI.B).
struct CorrectionOptions {
  double loop_sigma_m = 0.01;
  double loop_sigma_deg = 0.1;
  MapDrift drift;
  PoseGraphOptions graph;
};

/// Adjustment of the whole map after a loop.
struct WholeMapOptions {
  bool enabled = true;
  int min_sights = 3;
  int points_per_keyframe = 200;
  int lines_per_keyframe = 30;
  double relative_sigma = 1.0;
  BundleOptions bundle;

  WholeMapOptions() {
    bundle.max_iterations = 20;
    bundle.function_tolerance = 1e-3;
  }
};

/// When a camera of which nothing is known is found in the map.
struct RelocalisationOptions {
  int max_queried = 40;
  int max_candidates = 8;
  int min_inliers = 50;
  double min_inlier_share = 0.3;
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
void VisitFields(Visitor& visit, CandidateOptions& o) {
  visit("min_relative_score", o.min_relative_score, Bounds{0, 10},
        "similarity to a candidate, relative to that with the keyframe before");
  visit("min_shared", o.min_shared, Bounds{1, 10000},
        "landmarks that make two keyframes neighbours, which are no candidates, nor are their neighbours");
  visit("recent_keyframes", o.recent_keyframes, Bounds{1, 1000}, "newest keyframes of the session, no candidates");
  visit("group_keyframes", o.group_keyframes, Bounds{0, 1000},
        "best neighbours of a candidate whose similarities count with its own");
  visit("max_queried", o.max_queried, Bounds{1, 1000}, "most similar keyframes looked at");
  visit("max_candidates", o.max_candidates, Bounds{1, 100}, "places that are verified, the most similar ones");
  visit("near_m", o.near_m, Bounds{0, 1e6},
        "distance from which a loop was closed, a radian counting as two metres, above which it is measured again "
        "when the "
        "place is seen from half as far");
}

template <class Visitor>
void VisitFields(Visitor& visit, VerificationOptions& o) {
  visit("gates", o.gates, OneOf{"default", "paper"},
        "default, or the paper's three tests: eigenvalues of the covariance below 0.01, at most 0.50 m and 3.00 deg "
        "apart, more than half of the matches inliers");
  visit("local_keyframes", o.local_keyframes, Bounds{1, 1000}, "keyframes whose landmarks are the place");
  visit("min_matches", o.min_matches, Bounds{3, 10000}, "matches by descriptor (points + 2 x lines) worth a pose");
  visit("min_inliers", o.min_inliers, Bounds{3, 10000}, "inliers (points + 2 x lines) of the keyframe in the place");
  visit("min_reverse_inliers", o.min_reverse_inliers, Bounds{0, 10000},
        "inliers of the old keyframe among the landmarks of the new");
  visit("min_neighbour_inliers", o.min_neighbour_inliers, Bounds{3, 10000},
        "inliers with which a keyframe before the new one confirms the place");
  visit("strong_inliers", o.strong_inliers, Bounds{3, 100000},
        "inliers that make up for one confirming keyframe; twice as many for two");
  visit("min_inlier_share", o.min_inlier_share, Bounds{0, 1},
        "inliers relative to the landmarks of the old keyframe that should be in view and features that could show "
        "them");
  visit("min_inlier_share_unconnected", o.min_inlier_share_unconnected, Bounds{0, 1},
        "the same where nothing connects the two keyframes, so that no drift tells");
  visit("min_cells", o.min_cells, Bounds{1, 16}, "cells of a 4 x 4 grid over the image that must hold inliers");
  visit("consistent_keyframes", o.consistent_keyframes, Bounds{1, 10},
        "consecutive keyframes that must agree on the place, the new one included");
  visit("max_eigenvalue", o.max_eigenvalue, Bounds{1e-9, 1e6}, "largest eigenvalue of the covariance of the pose");
  visit("max_disagreement", o.max_disagreement, Bounds{0.0001, 10},
        "difference of positions seen from both sides or by neighbours, relative to the distance of the landmarks");
  visit("max_disagreement_deg", o.max_disagreement_deg, Bounds{0.01, 180}, "the same of rotations");
  visit("drift_per_m", o.drift_per_m, Bounds{0, 1}, "deviation of drift along the shortest way through the map");
  visit("drift_deg_per_m", o.drift_deg_per_m, Bounds{0, 90}, "the same of rotation");
  visit("covariance_scale", o.covariance_scale, Bounds{0, 1000},
        "factor on the deviations of the motions along that way");
  visit("max_drift_chi2", o.max_drift_chi2, Bounds{1, 1e12},
        "chi-square, 6 degrees of freedom, of a correction under that drift, above which a loop is not believed");
}

template <class Visitor>
void VisitFields(Visitor& visit, CorrectionOptions& o) {
  visit("loop_sigma_m", o.loop_sigma_m, Bounds{1e-6, 10}, "least deviation of a loop, all axes");
  visit("loop_sigma_deg", o.loop_sigma_deg, Bounds{1e-6, 90}, "the same of rotation");
  visit("drift_per_m", o.drift.per_m, Bounds{1e-6, 1},
        "deviation of the motion between keyframes of the map that share a hundred landmarks, for each metre");
  visit("drift_deg_per_m", o.drift.deg_per_m, Bounds{1e-6, 90}, "the same of rotation");
  visit("graph", o.graph, "pose graph");
}

template <class Visitor>
void VisitFields(Visitor& visit, WholeMapOptions& o) {
  visit("enabled", o.enabled, "adjust the whole map after each loop");
  visit("min_sights", o.min_sights, Bounds{2, 1000}, "keyframes that see a landmark which takes part");
  visit("points_per_keyframe", o.points_per_keyframe, Bounds{0, 100000},
        "points that take part, of each keyframe: those that most others see");
  visit("lines_per_keyframe", o.lines_per_keyframe, Bounds{0, 100000}, "the same of lines");
  visit("relative_sigma", o.relative_sigma, Bounds{0.01, 1e6},
        "deviation of the tracker's motion between keyframes, relative to what the tracker says of it");
  visit("bundle", o.bundle, "bundle adjustment");
}

template <class Visitor>
void VisitFields(Visitor& visit, RelocalisationOptions& o) {
  visit("max_queried", o.max_queried, Bounds{1, 1000}, "most similar keyframes looked at");
  visit("max_candidates", o.max_candidates, Bounds{1, 100}, "places that are verified, the most similar ones");
  visit("min_inliers", o.min_inliers, Bounds{3, 10000}, "inliers (points + 2 x lines) of the frame in the place");
  visit("min_inlier_share", o.min_inlier_share, Bounds{0, 1}, "as loop.verification.min_inlier_share");
  visit("max_rival_share", o.max_rival_share, Bounds{0, 1},
        "inliers of another pose elsewhere, relative to the best, above which neither is believed");
}

template <class Visitor>
void VisitFields(Visitor& visit, LoopOptions& o) {
  visit("enabled", o.enabled, "look for loops");
  visit("vocabularies", o.vocabularies, "words that places are described by");
  visit("places", o.places, "how similar two places look");
  visit("candidates", o.candidates, "which keyframes may show the same place");
  visit("localisation", o.localisation, "pose of a keyframe among the landmarks of a place");
  visit("verification", o.verification, "what a place must show to be believed");
  visit("correction", o.correction, "pose graph of the map with its loops");
  visit("adjustment", o.adjustment, "adjustment of the whole map after a loop");
  visit("relocalisation", o.relocalisation, "where a camera is of which nothing is known");
}

}  // namespace plslam
