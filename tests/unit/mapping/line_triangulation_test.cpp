// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/line_triangulation.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::DescriptorOf;
using test::FeatureWorld;
using test::HandmadeMap;

constexpr double kMinAngle_rad = 2.0 * M_PI / 180.0;
constexpr double kMaxDepthSigma = 0.3;
const Segment3 kHorizontal{{-0.6, 0.3, 3.0}, {0.6, 0.3, 3.0}};

SE3 Up(double metres) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, -metres, 0.0)}; }

SegmentView ViewOf(const Segment3& segment_w, const SE3& T_w_kf, double sigma_px = 0.5) {
  const SE3 T_kf_w = T_w_kf.Inverse();
  const StereoCamera camera = FeatureWorld::Camera();
  return {T_w_kf,
          Matrix6d::Zero(),
          {camera.Project(T_kf_w * segment_w.p), camera.Project(T_kf_w * segment_w.q)},
          sigma_px};
}

struct PoseSigma {
  double m = 0.0;
  double rad = 0.0;

  Vector6d All() const { return (Vector6d() << m, m, m, rad, rad, rad).finished(); }
  Matrix6d Covariance() const { return All().cwiseAbs2().asDiagonal(); }
};

std::optional<TriangulatedLine> Triangulate(const SegmentView& first, const SegmentView& second) {
  return TriangulateLine(first, second, FeatureWorld::Camera(), kMinAngle_rad, kMaxDepthSigma);
}

std::optional<TriangulatedLine> Triangulate(SegmentView first, SegmentView second, const PoseSigma& sigma) {
  first.covariance = second.covariance = sigma.Covariance();
  return Triangulate(first, second);
}

TEST(TriangulateLine, SegmentParallelToTheBaselineSeenFromAbove) {
  const auto line = Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(kHorizontal, Up(0.4)));
  ASSERT_TRUE(line);
  EXPECT_LT((line->segment_w.p - kHorizontal.p).norm(), 1e-9) << line->segment_w.p.transpose();
  EXPECT_LT((line->segment_w.q - kHorizontal.q).norm(), 1e-9) << line->segment_w.q.transpose();
}

TEST(TriangulateLine, CoversTheSegmentOfTheFirstView) {
  const Segment3 longer{{-1.0, 0.3, 3.0}, {0.2, 0.3, 3.0}};
  const auto line = Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(longer, Up(0.4)));
  ASSERT_TRUE(line);
  EXPECT_LT((line->segment_w.p - kHorizontal.p).norm(), 1e-9);
  EXPECT_LT((line->segment_w.q - kHorizontal.q).norm(), 1e-9);
}

TEST(TriangulateLine, PlanesAtTooSmallAnAngleGiveNone) {
  // The angle at 3 m depth: 1 degree for 5 cm, 4 degrees for 21 cm.
  EXPECT_FALSE(Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(kHorizontal, Up(0.05))));
  EXPECT_TRUE(Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(kHorizontal, Up(0.21))));
  const SE3 sideways(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.5, 0.0, 0.0));
  EXPECT_FALSE(Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(kHorizontal, sideways))) << "along the segment";
  EXPECT_FALSE(Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(kHorizontal, Up(0.0)))) << "the same view twice";
}

TEST(TriangulateLine, PlanesThatMeetBehindTheCameraGiveNone) {
  const SegmentView low = ViewOf(kHorizontal, Up(0.0));
  SegmentView high = ViewOf(kHorizontal, Up(0.4));
  // Diverging rays: the planes meet behind the camera.
  high.segment.p.y() = high.segment.q.y() = low.segment.p.y() - 40.0;
  EXPECT_FALSE(Triangulate(low, high));
}

// Segments of two lines far away, taken for one, seem to be one line next to the camera.
TEST(TriangulateLine, ViewsFromOnePositionGiveNone) {
  const Segment3 phantom{{-0.02, 0.005, 0.06}, {0.02, 0.005, 0.06}};
  const SegmentView low = ViewOf(phantom, Up(0.0));
  const SegmentView high = ViewOf(phantom, Up(0.003));
  EXPECT_TRUE(Triangulate(low, high, {})) << "poses without error";
  EXPECT_TRUE(Triangulate(low, high, {2e-4, 1e-5}));
  EXPECT_FALSE(Triangulate(low, high, {1e-3, 1e-4})) << "3 mm apart, give or take 1.4 mm";
  EXPECT_TRUE(Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(kHorizontal, Up(0.4)), {1e-3, 1e-4}));
}

TEST(TriangulateLine, ViewsOfOtherPartsGiveNone) {
  const Segment3 beside{{0.9, 0.3, 3.0}, {1.5, 0.3, 3.0}};
  EXPECT_FALSE(Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(beside, Up(0.4))));
  const Segment3 reversed{kHorizontal.q, kHorizontal.p};
  EXPECT_FALSE(Triangulate(ViewOf(kHorizontal, Up(0.0)), ViewOf(reversed, Up(0.4)))) << "the other way round";
}

TEST(TriangulateLine, NonsenseGivesNone) {
  const SegmentView good = ViewOf(kHorizontal, Up(0.0));
  SegmentView no_length = ViewOf(kHorizontal, Up(0.4));
  no_length.segment.q = no_length.segment.p;
  EXPECT_FALSE(Triangulate(good, no_length));
  EXPECT_FALSE(Triangulate(no_length, good));
  SegmentView not_finite = ViewOf(kHorizontal, Up(0.4));
  not_finite.segment.q.x() = std::nan("");
  EXPECT_FALSE(Triangulate(good, not_finite));
  EXPECT_FALSE(Triangulate(not_finite, good));
  const SegmentView infinite = ViewOf({{-6e4, 3e4, 3e5}, {6e4, 3e4, 3e5}}, Up(0.4));
  EXPECT_FALSE(Triangulate(ViewOf({{-6e4, 3e4, 3e5}, {6e4, 3e4, 3e5}}, Up(0.0)), infinite));
}

/// Mean of the squared errors across the line in units of the stated covariance: 2 where that is honest.
struct Consistency {
  double of_p = 0.0;
  double of_q = 0.0;
};

double SquaredAcross(const Eigen::Vector3d& error, const Eigen::Vector3d& along, const Eigen::Matrix3d& covariance) {
  Eigen::Matrix<double, 2, 3> across;
  across.row(0) = along.unitOrthogonal();
  across.row(1) = along.cross(Eigen::Vector3d(across.row(0)));
  const Eigen::Vector2d e = across * error;
  return e.dot((across * covariance * across.transpose()).inverse() * e);
}

Consistency MeasureConsistency(const Segment3& truth, double sigma_px, double up_m, const PoseSigma& pose) {
  constexpr int kRounds = 4000;
  std::mt19937_64 generator(3);
  std::normal_distribution<double> noise(0.0, sigma_px);
  const auto see = [&](const SE3& T_w_kf) {
    SegmentView view = ViewOf(truth, T_w_kf, sigma_px);
    for (double* value : {&view.segment.p.x(), &view.segment.p.y(), &view.segment.q.x(), &view.segment.q.y()}) {
      *value += noise(generator);
    }
    Vector6d error = pose.All();
    for (double& value : error) value *= noise(generator) / sigma_px;
    view.T_w_kf = T_w_kf * SE3::Exp(error);
    view.covariance = pose.Covariance();
    return view;
  };
  const Eigen::Vector3d along = (truth.q - truth.p).normalized();
  Consistency sum;
  for (int i = 0; i < kRounds; ++i) {
    const SegmentView first = see(Up(0.0));
    const auto line = Triangulate(first, see(Up(up_m)));
    if (!line) {
      ADD_FAILURE() << "round " << i;
      return sum;
    }
    // The error of the first pose moves the line with it, and is no error of the line.
    const SE3 T_true_seen = Up(0.0) * first.T_w_kf.Inverse();
    sum.of_p += SquaredAcross(T_true_seen * line->segment_w.p - truth.p, along, line->covariance_p) / kRounds;
    sum.of_q += SquaredAcross(T_true_seen * line->segment_w.q - truth.p, along, line->covariance_q) / kRounds;
  }
  return sum;
}

TEST(TriangulateLine, CovarianceIsHonest) {
  struct Case {
    const char* name;
    Segment3 segment_w;
    double up_m;
    PoseSigma pose{};
  };
  const Case cases[] = {{"frontal", kHorizontal, 0.4},
                        {"small angle", kHorizontal, 0.2},
                        {"seen low at the side", {{0.5, 1.2, 3.0}, {1.7, 1.2, 3.0}}, 0.4},
                        {"one end twice as far", {{-0.8, 0.3, 2.5}, {0.9, 0.3, 5.0}}, 0.4},
                        {"sloping", {{-0.6, 0.5, 3.0}, {0.6, 0.2, 3.0}}, 0.4},
                        {"wrong positions", kHorizontal, 0.4, {0.01, 0.0}},
                        {"wrong directions", kHorizontal, 0.4, {0.0, 0.004}},
                        {"wrong poses, low at the side", {{0.5, 1.2, 3.0}, {1.7, 1.2, 3.0}}, 0.4, {0.01, 0.003}}};
  for (const Case& c : cases) {
    const Consistency measured = MeasureConsistency(c.segment_w, 0.4, c.up_m, c.pose);
    for (const double value : {measured.of_p, measured.of_q}) {
      EXPECT_GT(value, 1.0) << c.name << ": p " << measured.of_p << ", q " << measured.of_q;
      EXPECT_LT(value, 3.0) << c.name << ": p " << measured.of_p << ", q " << measured.of_q;
    }
  }
}

/// Keyframes one above the other that share 30 points.
class TriangulateLines : public testing::Test {
 protected:
  TriangulateLines() {
    for (uint64_t i = 0; i < 40; ++i) descriptors_.push_back(DescriptorOf(i));
    for (const double up_m : {0.0, 0.2, 0.4}) m_.AddKeyframe(Up(up_m));
    m_.Tie({0, 1, 2}, 30, 0, descriptors_);
  }
  // As a front end must: no depth along the baseline.
  void See(KeyframeId keyframe_id, const Segment3& segment_w) {
    m_.SeeLine(keyframe_id, segment_w, look_);
    test::ChangeFeatures(m_.features, keyframe_id, [](StereoFeatures& of) {
      of.lines.back().disparity_p_px = of.lines.back().disparity_q_px = -1.0;
    });
  }
  std::vector<LandmarkId> Triangulate() {
    return plslam::mapping::TriangulateLines(2, Matrix6d::Zero(), m_.features, FeatureWorld::Camera(),
                                             MappingOptions(), ids_, m_.map);
  }

  std::vector<Descriptor> descriptors_;
  const Descriptor look_ = DescriptorOf(999);
  HandmadeMap m_;
  LandmarkIds ids_;
};

TEST_F(TriangulateLines, ThreeViewsMakeALandmark) {
  for (const int id : {0, 1, 2}) See(id, kHorizontal);
  const std::vector<LandmarkId> created = Triangulate();
  ASSERT_EQ(created.size(), 1U);
  const MapLine& line = *m_.map.FindLine(created[0]);
  EXPECT_EQ(line.observations.size(), 3U);
  EXPECT_LT((line.segment_w.p - kHorizontal.p).norm(), 1e-6) << line.segment_w.p.transpose();
  EXPECT_EQ(test::WrongWith(m_.map), "");
  EXPECT_TRUE(Triangulate().empty()) << "the second time they show a landmark";
}

TEST_F(TriangulateLines, TwoViewsAreNotEnough) {
  for (const int id : {0, 2}) See(id, kHorizontal);
  m_.map.TakeChanges();
  EXPECT_TRUE(Triangulate().empty());
  EXPECT_TRUE(m_.map.lines().empty());
}

TEST_F(TriangulateLines, ThirdViewRejectsAMismatch) {
  See(0, kHorizontal);
  See(2, {{-0.6, 0.45, 3.0}, {0.6, 0.45, 3.0}});
  See(1, kHorizontal);
  for (const LandmarkId id : Triangulate()) {
    ADD_FAILURE() << "line at y " << m_.map.FindLine(id)->segment_w.p.y() << ", z "
                  << m_.map.FindLine(id)->segment_w.p.z();
  }
}

TEST_F(TriangulateLines, LinesWithDepthAreSkipped) {
  for (const int id : {0, 1, 2}) m_.SeeLine(id, kHorizontal, look_);
  EXPECT_TRUE(Triangulate().empty());
}

}  // namespace
}  // namespace plslam::mapping
