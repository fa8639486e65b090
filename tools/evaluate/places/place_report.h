// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/evaluate/places/place_evaluation.h"

namespace plslam::evaluate {

/// The numbers of one sequence as aligned lines for a terminal.
std::string PlaceTable(const PlaceEvaluation& evaluation);

/// Returns the numbers of all sequences, with the curves and the definition of a revisit.
nlohmann::ordered_json PlacesToJson(const std::vector<PlaceEvaluation>& evaluations, const RevisitOptions& options);

/// Precision over recall of the best matches (left) and of all pairs (right), a line for each merge.
Drawing PrecisionRecallFigure(const PlaceEvaluation& evaluation);

}  // namespace plslam::evaluate
