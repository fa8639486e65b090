// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/volume.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include <openvdb/math/DDA.h>
#include <openvdb/math/Ray.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

namespace plslam::dense {
namespace {

using Sums = openvdb::Vec3f;  ///< of a voxel: weight * distance (in truncations), weight, weight * grey
/// Nodes of 1024 and 64 voxels: those of OpenVDB's default, of 4096 and 128, take megabytes on each side of the origin.
template <class Value>
using GridOf = openvdb::Grid<typename openvdb::tree::Tree4<Value, 4, 3, 3>::Type>;
using Grid = GridOf<Sums>;
using MaskGrid = GridOf<openvdb::ValueMask>;
using openvdb::Coord;
using openvdb::Vec3d;

// Bound on the weight of a voxel, so that a changed place is seen after as many images.
constexpr float kMostWeight = 100.0F;
// A volume that moves by less, in voxels, is not interpolated.
constexpr double kNegligible = 0.05;
// Weight of a ray that clears: two rays to a surface behind would have as much, and near the eye more would pass.
constexpr float kClearingWeight = 2.0F;
// Voxels that are farther in front of a surface, in truncations, are left as they are: rays that graze a floor would lower it.
constexpr float kObstacle = 0.34F;
// A bound is not as precise as a surface.
constexpr double kClearingMargin = 1.5 * Volume::kTruncation;
// Rays near the eye are much denser than voxels: of those that end in other voxels than every fourth, the first half is
// left out.
constexpr double kSharedPart = 0.5;

Vec3d ToVdb(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }
Eigen::Vector3d FromVdb(const Coord& ijk) { return {double(ijk.x()), double(ijk.y()), double(ijk.z())}; }
Coord Nearest(const Eigen::Vector3d& p) {
  return {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())),
          static_cast<int>(std::lround(p.z()))};
}

void AddTo(Sums& sums, const Sums& more) {
  sums += more;
  if (sums.y() > kMostWeight) sums *= kMostWeight / sums.y();
}

bool CarvesAll(const Coord& end) { return ((end.x() + end.y() + end.z()) & 3) == 0; }

Volume::Voxel ToVoxel(const Coord& ijk, const Sums& sums, double voxel_m) {
  const auto truncation_m = static_cast<float>(Volume::kTruncation * voxel_m);
  return {{ijk.x(), ijk.y(), ijk.z()}, truncation_m * sums.x() / sums.y(), sums.y(), sums.z() / sums.y()};
}

}  // namespace

struct Volume::Impl {
  Grid::Ptr grid = Grid::create(Sums(0.0F));
};

struct Volume::Reader::Impl {
  Grid::ConstAccessor accessor;
  double voxel_m;
};

Volume::Volume(double voxel_m) : voxel_m_(voxel_m), impl_(std::make_unique<Impl>()) {}
Volume::~Volume() = default;
Volume::Volume(Volume&& other) noexcept = default;
Volume& Volume::operator=(Volume&& other) noexcept = default;

size_t Volume::n_voxels() const { return impl_->grid->activeVoxelCount(); }
size_t Volume::bytes() const { return impl_->grid->memUsage(); }

void Volume::Integrate(const Eigen::Vector3d& eye, std::span<const DepthRay> rays) {
  Grid::Accessor accessor = impl_->grid->getAccessor();
  // DDA assigns a coordinate to the cell [n, n + 1); voxel centres are at integers.
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5);
  const Eigen::Vector3d from = eye / voxel_m_;
  for (const DepthRay& ray : rays) {
    const Eigen::Vector3d to = ray.end / voxel_m_;
    const double depth = (to - from).norm();
    if (!(depth > 1.0)) continue;
    const Eigen::Vector3d direction = (to - from) / depth;
    const double begin = CarvesAll(Nearest(to)) ? 0.0 : kSharedPart * depth;
    // Along a ray that grazes the surface, distances from it change slowly.
    const double end = depth + kTruncation / ray.incidence;
    openvdb::math::Ray<double> line(ToVdb(from + half), ToVdb(direction), begin, end);
    openvdb::math::DDA<openvdb::math::Ray<double>> dda(line, begin, end);
    do {
      const Coord ijk = dda.voxel();
      const double distance = (depth - (FromVdb(ijk) - from).dot(direction)) * ray.incidence;
      if (distance < -kTruncation) break;
      const auto d = static_cast<float>(std::min(distance / kTruncation, 1.0));
      // Behind the surface the weight falls to zero: another surface may follow.
      const float w = ray.weight * ray.incidence * (d < 0.0F ? 1.0F + d : 1.0F);
      accessor.modifyValue(ijk, [&](Sums& sums) { AddTo(sums, Sums(w * d, w, w * ray.grey)); });
    } while (dda.step());
  }
}

void Volume::Clear(const Eigen::Vector3d& eye, std::span<const Eigen::Vector3d> ends) {
  Grid::Accessor accessor = impl_->grid->getAccessor();
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5);
  const Eigen::Vector3d from = eye / voxel_m_;
  for (const Eigen::Vector3d& to_m : ends) {
    const Eigen::Vector3d to = to_m / voxel_m_;
    const double end = (to - from).norm() - kClearingMargin;
    if (!(end > 1.0)) continue;
    openvdb::math::Ray<double> line(ToVdb(from + half), ToVdb((to - from).normalized()), 0.0, end);
    openvdb::math::DDA<openvdb::math::Ray<double>> dda(line, 0.0, end);
    do {
      Sums sums;
      if (!accessor.probeValue(dda.voxel(), sums) || sums.y() < kLeastWeight) continue;
      if (sums.x() > kObstacle * sums.y()) continue;
      AddTo(sums, Sums(kClearingWeight, kClearingWeight, kClearingWeight * sums.z() / sums.y()));
      accessor.setValue(dda.voxel(), sums);
    } while (dda.step());
  }
}

void Volume::Add(const Volume& other, const SE3& T_this_other) {
  Grid::Accessor accessor = impl_->grid->getAccessor();
  const SE3 T_in_voxels(T_this_other.rotation(), T_this_other.translation() / voxel_m_);
  const openvdb::CoordBBox box = other.impl_->grid->evalActiveVoxelBoundingBox();
  if (box.empty()) return;
  double motion = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p((corner & 1) != 0 ? box.max().x() : box.min().x(),
                            (corner & 2) != 0 ? box.max().y() : box.min().y(),
                            (corner & 4) != 0 ? box.max().z() : box.min().z());
    motion = std::max(motion, (T_in_voxels * p - p).norm());
  }
  if (motion < kNegligible) {
    for (auto voxel = other.impl_->grid->cbeginValueOn(); voxel; ++voxel) {
      const Sums more = *voxel;
      accessor.modifyValue(voxel.getCoord(), [&](Sums& sums) { AddTo(sums, more); });
    }
    return;
  }
  // The target voxels: those within one voxel of a moved one.
  MaskGrid targets;
  {
    MaskGrid::Accessor mask = targets.getAccessor();
    for (auto voxel = other.impl_->grid->cbeginValueOn(); voxel; ++voxel) {
      const Eigen::Vector3d p = (T_in_voxels * FromVdb(voxel.getCoord())).array().floor();
      const Coord base = Nearest(p);
      for (int corner = 0; corner < 8; ++corner) {
        mask.setValueOn(base.offsetBy(corner & 1, corner >> 1 & 1, corner >> 2 & 1));
      }
    }
  }
  const SE3 T_other_this = T_in_voxels.Inverse();
  const Grid::ConstAccessor source = other.impl_->grid->getConstAccessor();
  for (auto target = targets.cbeginValueOn(); target; ++target) {
    const Vec3d at = ToVdb(T_other_this * FromVdb(target.getCoord()));
    Sums more(0.0F);
    openvdb::tools::BoxSampler::sample(source, at, more);
    if (more.y() < kLeastWeight) continue;
    accessor.modifyValue(target.getCoord(), [&](Sums& sums) { AddTo(sums, more); });
  }
}

void Volume::Visit(const std::function<void(const Voxel&)>& visit) const {
  for (auto voxel = impl_->grid->cbeginValueOn(); voxel; ++voxel) {
    if (voxel->y() >= kLeastWeight) visit(ToVoxel(voxel.getCoord(), *voxel, voxel_m_));
  }
}

std::vector<Volume::Block> Volume::Blocks() const {
  std::vector<Block> blocks;
  for (auto leaf = impl_->grid->tree().cbeginLeaf(); leaf; ++leaf) {
    Block block;
    const Coord origin = leaf->origin();
    block.origin = {origin.x(), origin.y(), origin.z()};
    for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel) {
      block.known[voxel.pos() / 64] |= uint64_t{1} << voxel.pos() % 64;
      for (int i = 0; i < 3; ++i) block.sums.push_back((*voxel)[i]);
    }
    if (!block.sums.empty()) blocks.push_back(std::move(block));
  }
  return blocks;
}

Volume Volume::FromBlocks(double voxel_m, std::span<const Block> blocks) {
  constexpr int kSize = 8;
  constexpr int kFarthest = 1 << 20;  // voxels from the origin
  Volume volume(voxel_m);
  Grid::Accessor accessor = volume.impl_->grid->getAccessor();
  for (const Block& block : blocks) {
    for (const int32_t i : block.origin) {
      if (i % kSize != 0 || std::abs(i) > kFarthest)
        throw std::runtime_error("a block of voxels is at no valid place");
    }
    const Coord origin(block.origin[0], block.origin[1], block.origin[2]);
    size_t next = 0;
    for (uint32_t position = 0; position < 512; ++position) {
      if ((block.known[position / 64] >> position % 64 & 1) == 0) continue;
      if (block.sums.size() < next + 3) throw std::runtime_error("a block has fewer voxels than it states");
      const Sums sums(block.sums[next], block.sums[next + 1], block.sums[next + 2]);
      next += 3;
      const bool valid = sums.y() >= 0.0F && sums.y() <= 1.001F * kMostWeight &&
                         std::abs(sums.x()) <= 1.001F * sums.y() && sums.z() >= 0.0F && sums.z() <= 256.0F * sums.y();
      if (!valid) throw std::runtime_error("a voxel has impossible values");
      accessor.setValue(origin + Grid::TreeType::LeafNodeType::offsetToLocalCoord(position), sums);
    }
    if (next != block.sums.size()) throw std::runtime_error("a block has more voxels than it states");
  }
  return volume;
}

Volume::Reader::Reader(const Volume& volume)
    : impl_(new Impl{volume.impl_->grid->getConstAccessor(), volume.voxel_m_}) {}
Volume::Reader::~Reader() = default;

std::optional<Volume::Voxel> Volume::Reader::At(const Eigen::Vector3i& index) const {
  const Coord ijk(index.x(), index.y(), index.z());
  const Sums& sums = impl_->accessor.getValue(ijk);
  if (sums.y() < kLeastWeight) return std::nullopt;
  return ToVoxel(ijk, sums, impl_->voxel_m);
}

}  // namespace plslam::dense
