#include "core/geometry/distortion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace plslam {
namespace {

// No rectified image looks farther from its axis than about 84 degrees.
constexpr double kLargestRadius = 10.0;
constexpr int kScanSteps = 2000;

std::runtime_error WrongCount(const CameraCalibration& c, const char* expected) {
  return std::runtime_error("distortion model \"" + c.model + "\" takes " + expected + " coefficients, not " +
                            std::to_string(c.distortion.size()));
}

void RequireFinite(const CameraCalibration& c) {
  for (const double k : c.distortion) {
    if (!std::isfinite(k)) {
      throw std::runtime_error("distortion model \"" + c.model + "\" has a coefficient that is no number");
    }
  }
}

}  // namespace

Distortion::Distortion(const CameraCalibration& c) {
  RequireFinite(c);
  const size_t n = c.distortion.size();
  double end = kLargestRadius;
  if (c.model == "radtan") {
    if (n != 4 && n != 5) throw WrongCount(c, "4 or 5");
    model_ = Model::kRadtan;
    k_[0] = c.distortion[0];
    k_[1] = c.distortion[1];
    p_[0] = c.distortion[2];
    p_[1] = c.distortion[3];
    if (n == 5) k_[2] = c.distortion[4];
  } else if (c.model == "equidistant") {
    if (n != 4) throw WrongCount(c, "4");
    model_ = Model::kEquidistant;
    std::copy(c.distortion.begin(), c.distortion.end(), k_);
    end = std::atan(kLargestRadius);
  } else if (c.model != "pinhole") {
    throw std::runtime_error("unknown distortion model \"" + c.model + "\" (pinhole, radtan or equidistant)");
  } else if (std::any_of(c.distortion.begin(), c.distortion.end(), [](double k) { return k != 0.0; })) {
    throw std::runtime_error("distortion model \"pinhole\" has coefficients that are not zero");
  }
  max_profile_variable_ = MonotonicLimit(end);
  max_radius_ = model_ == Model::kEquidistant ? std::tan(max_profile_variable_) : max_profile_variable_;
}

bool Distortion::IsIdentity() const {
  const bool no_terms = std::all_of(k_, k_ + 4, [](double k) { return k == 0.0; }) && p_[0] == 0.0 && p_[1] == 0.0;
  return model_ == Model::kPinhole || (model_ == Model::kRadtan && no_terms);
}

double Distortion::Profile(double s) const {
  const double s2 = s * s;
  return s * (1.0 + s2 * (k_[0] + s2 * (k_[1] + s2 * (k_[2] + s2 * k_[3]))));
}

double Distortion::ProfileDerivative(double s) const {
  const double s2 = s * s;
  return 1.0 + s2 * (3.0 * k_[0] + s2 * (5.0 * k_[1] + s2 * (7.0 * k_[2] + s2 * 9.0 * k_[3])));
}

double Distortion::MonotonicLimit(double end) const {
  double below = 0.0;
  for (int i = 1; i <= kScanSteps; ++i) {
    double above = end * i / kScanSteps;
    if (ProfileDerivative(above) > 0.0) {
      below = above;
      continue;
    }
    for (int halving = 0; halving < 50; ++halving) {
      const double middle = 0.5 * (below + above);
      (ProfileDerivative(middle) > 0.0 ? below : above) = middle;
    }
    break;
  }
  return below;
}

Eigen::Vector2d Distortion::Apply(const Eigen::Vector2d& xy) const {
  if (model_ == Model::kPinhole) return xy;
  if (model_ == Model::kRadtan) return Radtan(xy.x(), xy.y(), xy.squaredNorm());
  const double r = xy.norm();
  return r < 1e-9 ? xy : Eigen::Vector2d(Profile(std::atan(r)) / r * xy);
}

Eigen::Vector2d Distortion::Radtan(double x, double y, double r2) const {
  const double radial = 1.0 + r2 * (k_[0] + r2 * (k_[1] + r2 * k_[2]));
  const double xy2 = 2.0 * x * y;
  return {x * radial + p_[0] * xy2 + p_[1] * (r2 + 2.0 * x * x),
          y * radial + p_[0] * (r2 + 2.0 * y * y) + p_[1] * xy2};
}

std::optional<Eigen::Vector2d> Distortion::Distort(const Eigen::Vector2d& xy) const {
  // The negated comparison also refuses NaN.
  if (!(xy.squaredNorm() <= max_radius_ * max_radius_)) return std::nullopt;
  return Apply(xy);
}

void Distortion::Distort(std::span<double> x, std::span<double> y) const {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  if (model_ == Model::kRadtan) {
    // No branch and no call, so that it becomes vector code.
    const double largest = max_radius_ * max_radius_;
    for (size_t i = 0; i < x.size(); ++i) {
      const double r2 = x[i] * x[i] + y[i] * y[i];
      const Eigen::Vector2d distorted = Radtan(x[i], y[i], r2);
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
  if (model_ == Model::kEquidistant) {
    const double r = std::sqrt(r2);
    if (r < 1e-9) return Eigen::Matrix2d::Identity();
    const double theta = std::atan(r);
    const double scale = Profile(theta) / r;
    const double slope = (ProfileDerivative(theta) / (1.0 + r2) - scale) / r2;
    return scale * Eigen::Matrix2d::Identity() + slope * xy * xy.transpose();
  }
  const double radial = 1.0 + r2 * (k_[0] + r2 * (k_[1] + r2 * k_[2]));
  const double slope = 2.0 * (k_[0] + r2 * (2.0 * k_[1] + r2 * 3.0 * k_[2]));
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
  if (radius < 1e-12) return distorted;
  // Bisection of the radial part never leaves the monotonic range; Newton then adds the tangential part.
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
