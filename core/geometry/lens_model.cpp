// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/lens_model.h"

#include <algorithm>
#include <array>

namespace plslam {
namespace {

// The order of the coefficients is OpenCV's for the first three, Kalibr's for the other two.
constexpr std::array<LensModel, 5> kModels = {{{"pinhole", 0, 0, "none"},
                                               {"radtan", 4, 5, "k1 k2 p1 p2 [k3]"},
                                               {"rational", 8, 8, "k1 k2 p1 p2 k3 k4 k5 k6"},
                                               {"equidistant", 4, 4, "k1 k2 k3 k4"},
                                               {"double_sphere", 2, 2, "xi alpha"}}};

}  // namespace

std::span<const LensModel> LensModels() { return kModels; }

const LensModel* FindLensModel(std::string_view name) {
  const auto* found =
      std::find_if(kModels.begin(), kModels.end(), [&](const LensModel& m) { return m.name == name; });
  return found == kModels.end() ? nullptr : found;
}

std::string LensModelNames() {
  std::string names;
  for (const LensModel& model : kModels) names.append(names.empty() ? "" : ", ").append(model.name);
  return names;
}

bool LensModelTakes(std::string_view name, size_t n_coefficients) {
  const LensModel* model = FindLensModel(name);
  return model != nullptr && n_coefficients >= model->min_coefficients && n_coefficients <= model->max_coefficients;
}

}  // namespace plslam
