// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace plslam {

/// The lens models by name, with the numbers of coefficients that each may have.
struct LensModel {
  std::string_view name;
  size_t min_coefficients;
  size_t max_coefficients;
  std::string_view coefficients;
};

/// All of them, in the order in which they are told.
std::span<const LensModel> LensModels();

/// nullptr where there is none of that name.
const LensModel* FindLensModel(std::string_view name);

/// "pinhole, radtan, ...".
std::string LensModelNames();

/// Whether a model of that name may have so many coefficients.
bool LensModelTakes(std::string_view name, size_t n_coefficients);

}  // namespace plslam
