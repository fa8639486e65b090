// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/distortion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace plslam {
namespace {

// Coefficients are in OpenCV's order for the first three models, in Kalibr's for the other two.
constexpr std::array<LensModel, 5> kModels = {{{lens_model::kPinhole, 0, 0, "none"},
                                               {lens_model::kRadtan, 4, 5, "k1 k2 p1 p2 [k3]"},
                                               {lens_model::kRational, 8, 8, "k1 k2 p1 p2 k3 k4 k5 k6"},
                                               {lens_model::kEquidistant, 4, 4, "k1 k2 k3 k4"},
                                               {lens_model::kDoubleSphere, 2, 2, "xi alpha"}}};

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

namespace {

// Rectified images never extend farther than about 84 degrees from the axis.
constexpr double kLargestRadius = 10.0;
constexpr int kScanSteps = 2000;

void RequireKnown(const CameraCalibration& c) {
  const LensModel* model = FindLensModel(c.model);
  if (model == nullptr) {
    throw std::runtime_error("unknown distortion model \"" + c.model + "\" (" + LensModelNames() + ")");
  }
  // A pinhole may keep zero coefficients of a former model.
  const bool zeros = std::all_of(c.distortion.begin(), c.distortion.end(), [](double k) { return k == 0.0; });
  if (c.model == lens_model::kPinhole && !zeros) {
    throw std::runtime_error("distortion model \"pinhole\" has coefficients that are not zero");
  }
  if (c.model != lens_model::kPinhole && !LensModelTakes(c.model, c.distortion.size())) {
    throw std::runtime_error("distortion model \"" + c.model + "\" takes the coefficients " +
                             std::string(model->coefficients) + ", not " + std::to_string(c.distortion.size()));
  }
}

void RequireFinite(const CameraCalibration& c) {
  for (const double k : c.distortion) {
    if (!std::isfinite(k)) {
      throw std::runtime_error("distortion model \"" + c.model + "\" has a coefficient that is not a number");
    }
  }
}

}  // namespace

Distortion::Distortion(const CameraCalibration& c) {
  RequireFinite(c);
  RequireKnown(c);
  const std::vector<double>& d = c.distortion;
  double end = kLargestRadius;
  if (c.model == lens_model::kRadtan || c.model == lens_model::kRational) {
    model_ = c.model == lens_model::kRadtan ? Model::kRadtan : Model::kRational;
    k_[0] = d[0];
    k_[1] = d[1];
    p_[0] = d[2];
    p_[1] = d[3];
    if (d.size() > 4) k_[2] = d[4];
    if (model_ == Model::kRational) std::copy(d.begin() + 5, d.end(), divisor_);
  } else if (c.model == lens_model::kEquidistant) {
    model_ = Model::kEquidistant;
    std::copy(d.begin(), d.end(), k_);
    end = std::atan(kLargestRadius);
  } else if (c.model == lens_model::kDoubleSphere) {
    model_ = Model::kDoubleSphere;
    xi_ = d[0];
    alpha_ = d[1];
  }
  max_profile_variable_ = MonotonicLimit(end);
  max_radius_ = model_ == Model::kEquidistant ? std::tan(max_profile_variable_) : max_profile_variable_;
}

bool Distortion::IsIdentity() const {
  const auto is_zero = [](double k) { return k == 0.0; };
  const bool no_terms = std::all_of(k_, k_ + 4, is_zero) && std::all_of(p_, p_ + 2, is_zero) &&
                        std::all_of(divisor_, divisor_ + 3, is_zero);
  if (model_ == Model::kDoubleSphere) return xi_ == 0.0 && alpha_ == 0.0;
  return model_ == Model::kPinhole || (model_ != Model::kEquidistant && no_terms);
}

double Distortion::Profile(double s) const {
  const double s2 = s * s;
  if (model_ == Model::kDoubleSphere) return s / Denominator(s);
  const double polynomial = s * (1.0 + s2 * (k_[0] + s2 * (k_[1] + s2 * (k_[2] + s2 * k_[3]))));
  return model_ == Model::kRational ? polynomial / Denominator(s) : polynomial;
}

double Distortion::ProfileDerivative(double s) const {
  const double s2 = s * s;
  if (model_ == Model::kRational) return RadialFactor(s2) + 2.0 * s2 * RadialFactorDerivative(s2);
  if (model_ == Model::kDoubleSphere) {
    const double d1 = std::sqrt(s2 + 1.0);
    const double depth = xi_ * d1 + 1.0;
    const double d2 = std::sqrt(s2 + depth * depth);
    const double depth_slope = xi_ * s / d1;
    const double slope = alpha_ * (s + depth * depth_slope) / d2 + (1.0 - alpha_) * depth_slope;
    const double denominator = Denominator(s);
    return (denominator - s * slope) / (denominator * denominator);
  }
  return 1.0 + s2 * (3.0 * k_[0] + s2 * (5.0 * k_[1] + s2 * (7.0 * k_[2] + s2 * 9.0 * k_[3])));
}

double Distortion::Denominator(double s) const {
  const double s2 = s * s;
  if (model_ == Model::kRational) return Divisor(s2);
  if (model_ != Model::kDoubleSphere) return 1.0;
  const double depth = xi_ * std::sqrt(s2 + 1.0) + 1.0;
  return alpha_ * std::sqrt(s2 + depth * depth) + (1.0 - alpha_) * depth;
}

double Distortion::Divisor(double r2) const {
  return 1.0 + r2 * (divisor_[0] + r2 * (divisor_[1] + r2 * divisor_[2]));
}

double Distortion::RadialFactor(double r2) const {
  const double radial = 1.0 + r2 * (k_[0] + r2 * (k_[1] + r2 * k_[2]));
  if (model_ != Model::kRational) return radial;
  return radial / Divisor(r2);
}

double Distortion::RadialFactorDerivative(double r2) const {
  const double slope = k_[0] + r2 * (2.0 * k_[1] + r2 * 3.0 * k_[2]);
  if (model_ != Model::kRational) return slope;
  const double denominator = Divisor(r2);
  const double denominator_slope = divisor_[0] + r2 * (2.0 * divisor_[1] + r2 * 3.0 * divisor_[2]);
  return (slope - RadialFactor(r2) * denominator_slope) / denominator;
}

double Distortion::MonotonicLimit(double end) const {
  const auto grows = [this](double s) { return Denominator(s) > 0.0 && ProfileDerivative(s) > 0.0; };
  double below = 0.0;
  for (int i = 1; i <= kScanSteps; ++i) {
    double above = end * i / kScanSteps;
    if (grows(above)) {
      below = above;
      continue;
    }
    for (int halving = 0; halving < 50; ++halving) {
      const double middle = 0.5 * (below + above);
      (grows(middle) ? below : above) = middle;
    }
    break;
  }
  return below;
}

Eigen::Vector2d Distortion::Apply(const Eigen::Vector2d& xy) const {
  if (model_ == Model::kPinhole) return xy;
  if (model_ == Model::kRadtan || model_ == Model::kRational) {
    const double r2 = xy.squaredNorm();
    return Radtan(xy.x(), xy.y(), r2, RadialFactor(r2));
  }
  const double r = xy.norm();
  if (model_ == Model::kDoubleSphere) return xy / Denominator(r);
  return r < 1e-9 ? xy : Eigen::Vector2d(Profile(std::atan(r)) / r * xy);
}

Eigen::Vector2d Distortion::Radtan(double x, double y, double r2, double radial) const {
  const double xy2 = 2.0 * x * y;
  return {x * radial + p_[0] * xy2 + p_[1] * (r2 + 2.0 * x * x),
          y * radial + p_[0] * (r2 + 2.0 * y * y) + p_[1] * xy2};
}

std::optional<Eigen::Vector2d> Distortion::Distort(const Eigen::Vector2d& xy) const {
  // The negated comparison also rejects NaN.
  if (!(xy.squaredNorm() <= max_radius_ * max_radius_)) return std::nullopt;
  return Apply(xy);
}

void Distortion::Distort(std::span<double> x, std::span<double> y) const {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  if (model_ == Model::kRadtan) {
    // No branches and no calls, so that the loop is vectorised.
    const double largest = max_radius_ * max_radius_;
    for (size_t i = 0; i < x.size(); ++i) {
      const double r2 = x[i] * x[i] + y[i] * y[i];
      const double radial = 1.0 + r2 * (k_[0] + r2 * (k_[1] + r2 * k_[2]));
      const Eigen::Vector2d distorted = Radtan(x[i], y[i], r2, radial);
      x[i] = r2 <= largest ? distorted.x() : kNothing;
      y[i] = r2 <= largest ? distorted.y() : kNothing;
    }
    return;
  }
  for (size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector2d distorted =
        Distort(Eigen::Vector2d(x[i], y[i])).value_or(Eigen::Vector2d(kNothing, kNothing));
    x[i] = distorted.x();
    y[i] = distorted.y();
  }
}

Eigen::Matrix2d Distortion::Jacobian(const Eigen::Vector2d& xy) const {
  if (model_ == Model::kPinhole) return Eigen::Matrix2d::Identity();
  const double x = xy.x();
  const double y = xy.y();
  const double r2 = xy.squaredNorm();
  if (model_ == Model::kEquidistant || model_ == Model::kDoubleSphere) {
    const double r = std::sqrt(r2);
    if (r < 1e-9) return CentreScale() * Eigen::Matrix2d::Identity();
    const bool by_angle = model_ == Model::kEquidistant;
    const double s = by_angle ? std::atan(r) : r;
    const double scale = Profile(s) / r;
    const double derivative = by_angle ? ProfileDerivative(s) / (1.0 + r2) : ProfileDerivative(s);
    const double slope = (derivative - scale) / r2;
    return scale * Eigen::Matrix2d::Identity() + slope * xy * xy.transpose();
  }
  const double radial = RadialFactor(r2);
  const double slope = 2.0 * RadialFactorDerivative(r2);
  Eigen::Matrix2d J = radial * Eigen::Matrix2d::Identity() + slope * xy * xy.transpose();
  const double cross = 2.0 * (p_[0] * x + p_[1] * y);
  J(0, 0) += 2.0 * p_[0] * y + 6.0 * p_[1] * x;
  J(0, 1) += cross;
  J(1, 0) += cross;
  J(1, 1) += 6.0 * p_[0] * y + 2.0 * p_[1] * x;
  return J;
}

double Distortion::InvertProfile(double distorted_radius) const {
  double below = 0.0;
  double above = max_profile_variable_;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (below + above);
    (Profile(middle) < distorted_radius ? below : above) = middle;
  }
  return 0.5 * (below + above);
}

std::optional<Eigen::Vector2d> Distortion::Undistort(const Eigen::Vector2d& distorted) const {
  if (!distorted.allFinite()) return std::nullopt;
  if (model_ == Model::kPinhole) return Distort(distorted);
  const double radius = distorted.norm();
  if (radius < 1e-12) return Eigen::Vector2d(distorted / CentreScale());
  // Bisection of the radial part stays in the monotonic range; Newton then adds the tangential part.
  const double variable = InvertProfile(radius);
  const double start = model_ == Model::kEquidistant ? std::tan(variable) : variable;
  Eigen::Vector2d xy = start / radius * distorted;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Eigen::Matrix2d J = Jacobian(xy);
    const double determinant = J.determinant();
    const Eigen::Vector2d error = distorted - Apply(xy);
    if (error.norm() < 1e-13) break;
    if (!(determinant > 1e-12)) break;
    Eigen::Matrix2d adjugate;
    adjugate << J(1, 1), -J(0, 1), -J(1, 0), J(0, 0);
    xy += adjugate * error / determinant;
  }
  const bool reached = (distorted - Apply(xy)).norm() < 1e-9 && xy.norm() <= max_radius_;
  return reached ? std::optional(xy) : std::nullopt;
}

}  // namespace plslam
