#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// Pose graph (PL-SLAM §VI.B). The defaults are for closing a loop from a map that is nearly right.
struct PoseGraphOptions {
  std::string start = "given";
  int max_iterations = 30;
  double function_tolerance = 1e-5;
  double rejection_chi2 = 100.0;
};

template <class Visitor>
void VisitFields(Visitor& visit, PoseGraphOptions& o) {
  visit("start", o.start, OneOf{"given", "chordal", "best"},
        "where iterations begin: at the poses as given, at the chordal relaxation of the rotations with the "
        "translations that follow (Carlone et al. 2015), or from whichever of the two ends lower");
  visit("max_iterations", o.max_iterations, Bounds{1, 10000}, "Levenberg-Marquardt iterations of each solve");
  visit("function_tolerance", o.function_tolerance, Bounds{0, 1},
        "share of the cost that a step must gain for another one to follow");
  visit("rejection_chi2", o.rejection_chi2, Bounds{1, 1e12},
        "a loop edge is taken out where the rest of the graph contradicts it by more than this chi-square (6 degrees "
        "of freedom; 100 allows for drift beyond what covariances say)");
}

}  // namespace plslam
