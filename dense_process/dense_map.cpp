// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/dense_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "core/files/archive.h"
#include "core/files/sealed_file.h"

namespace plslam::dense {
namespace {

// A submap ends after so many keyframes, or at this distance from its anchor, in voxels: over that length the local map
// is rigid to a fraction of a voxel.
constexpr size_t kMostKeyframes = 10;
constexpr double kLargest = 60.0;

// Views of a submap that others have joined: the newest are kept.
constexpr size_t kMostViews = 3 * kMostKeyframes;

// A submap knows a surface if its own is nearer than so many voxels.
constexpr double kSameSurface = 2.0;

constexpr double kLargestVoxel_m = 1.0;
constexpr float kFarthest_m = 1e6F;  // from the origin of a submap
constexpr double kUnit = 1e-9;       // rounding of unit quaternions

constexpr FileKind kSurfaces{{'P', 'L', 'S', 'L', 'S', 'U', 'R', 'F'}, 6, "surfaces file"};

/// Distance up to which a keyframe sees surfaces: the farthest at which its depth is in use with this error of a
/// disparity.
constexpr double kSigma_px = 0.25;
double RangeOf(const StereoCamera& camera, double voxel_m) {
  return std::sqrt(kSigmasInVoxels * voxel_m * camera.FocalBaseline() / kSigma_px);
}

// Points of a surface that are compared with the views of keyframes, and the share of them that must be seen.
constexpr size_t kSampledPoints = 500;
constexpr double kLeastSeen = 0.5;

/// Points of the surface of a volume, at most about `kSampledPoints`, in a fixed order.
std::vector<Eigen::Vector3d> SampleSurface(const Volume& volume) {
  std::vector<Eigen::Vector3d> all;
  volume.Visit([&](const Volume::Voxel& voxel) {
    // Also those that were seen once: other submaps may have seen them, too.
    if (std::abs(voxel.distance_m) < 0.5 * volume.voxel_m()) all.push_back(volume.Centre(voxel.index));
  });
  std::vector<Eigen::Vector3d> points;
  const size_t step = 1 + all.size() / kSampledPoints;
  for (size_t i = 0; i < all.size(); i += step) points.push_back(all[i]);
  return points;
}

}  // namespace

/// A submap in a file.
struct DenseMap::StoredSubmap {
  std::vector<Member> members;
  std::vector<Volume::Block> blocks;  ///< of the newest submap; `packed`: of the others
  PackedVolume packed;
  struct View {
    uint64_t submap = 0;
    std::vector<float> numbers;  ///< x, y, z of the eye, and of each end

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.submap, self.numbers);
    }
  };
  std::vector<View> views;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.members, self.blocks, self.packed, self.views);
  }
};

/// The voxels of a submap, unpacked for as long as they are read.
class DenseMap::Voxels {
 public:
  Voxels(const Submap& submap, double voxel_m) : growing_(submap.growing ? &*submap.growing : nullptr) {
    if (growing_ == nullptr) unpacked_.emplace(submap.packed.Unpack(voxel_m));
  }
  const Volume& operator*() const { return growing_ != nullptr ? *growing_ : *unpacked_; }

 private:
  const Volume* growing_;
  std::optional<Volume> unpacked_;
};

size_t DenseMap::n_submaps() const {
  return static_cast<size_t>(std::ranges::count_if(submaps_, [](const Submap& s) { return !s.members.empty(); }));
}

size_t DenseMap::bytes() const {
  size_t bytes = 0;
  for (const Submap& submap : submaps_) {
    bytes += submap.packed.bytes() + (submap.growing ? submap.growing->bytes() : 0);
    for (const BoundedView& view : submap.views) bytes += view.ends.capacity() * sizeof(view.ends.front());
  }
  return bytes;
}

double DenseMap::BytesPerCubicMetre() const {
  size_t n_voxels = 0;
  for (const Submap& submap : submaps_)
    n_voxels += submap.packed.n_voxels() + (submap.growing ? submap.growing->n_voxels() : 0);
  const double space_m3 = static_cast<double>(n_voxels) * voxel_m_ * voxel_m_ * voxel_m_;
  return n_voxels > 0 ? static_cast<double>(bytes()) / space_m3 : 0.0;
}

bool DenseMap::Continues(const KeyframeFrame& keyframe, const SE3& T_w_kf, const KeyframePoses& poses) const {
  if (submaps_.empty()) return false;
  const Submap& newest = submaps_.back();
  if (newest.members.empty() || newest.members.size() >= kMostKeyframes) return false;
  const KeyframeFrame& first = newest.members.front().keyframe;
  const auto anchor = poses.find(first);
  if (anchor == poses.end() || first.first != keyframe.first) return false;
  return (T_w_kf.translation() - anchor->second.translation()).norm() < kLargest * voxel_m_;
}

bool DenseMap::Add(const KeyframeFrame& keyframe, const DepthImage& depth, const cv::Mat& grey,
                   const StereoCamera& camera, const KeyframePoses& poses) {
  const auto pose = poses.find(keyframe);
  if (pose == poses.end()) return false;
  const SE3& T_w_kf = pose->second;
  if (!Continues(keyframe, T_w_kf, poses)) {
    if (!submaps_.empty()) {
      submaps_.back().packed = PackedVolume(*submaps_.back().growing);
      submaps_.back().growing.reset();
    }
    submaps_.push_back({{}, Volume(voxel_m_), {}, {}});
  }
  Submap& submap = submaps_.back();
  const Member* const first = submap.members.empty() ? nullptr : &submap.members.front();
  const SE3 T_s_kf = first == nullptr ? T_w_kf : first->T_s_kf * poses.at(first->keyframe).Inverse() * T_w_kf;
  const double range_m = range_m_ > 0.0 ? range_m_ : std::numeric_limits<double>::infinity();
  submap.growing->Integrate(T_s_kf.translation(), MakeRays(depth, grey, camera, T_s_kf, voxel_m_, range_m));
  const std::vector<Eigen::Vector3d> ends = MakeBoundEnds(depth, camera, T_s_kf, voxel_m_, range_m);
  if (!ends.empty()) {
    BoundedView& view = submap.views.emplace_back();
    view.submap = submaps_.size() - 1;
    view.eye = T_s_kf.translation().cast<float>();
    view.ends.reserve(ends.size());
    for (const Eigen::Vector3d& end : ends) view.ends.push_back(end.cast<float>());
  }
  submap.members.push_back({keyframe, T_s_kf});
  fused_.insert(keyframe);
  return true;
}

std::set<KeyframeFrame> DenseMap::Members() const {
  std::set<KeyframeFrame> members;
  for (const Submap& submap : submaps_) {
    for (const Member& member : submap.members) members.insert(member.keyframe);
  }
  return members;
}

/// The first keyframe whose place is known; nullptr: none.
const DenseMap::Member* DenseMap::AnchorOf(const Submap& submap, const KeyframePoses& poses) {
  const auto found =
      std::ranges::find_if(submap.members, [&](const Member& member) { return poses.contains(member.keyframe); });
  return found == submap.members.end() ? nullptr : &*found;
}

/// T_w_s; nullopt: the submap has no place.
std::optional<SE3> DenseMap::PoseOf(const Submap& submap, const KeyframePoses& poses) {
  const Member* const anchor = AnchorOf(submap, poses);
  if (anchor == nullptr) return std::nullopt;
  return poses.at(anchor->keyframe) * anchor->T_s_kf.Inverse();
}

size_t DenseMap::CountUnplaced(const KeyframePoses& poses) const {
  return static_cast<size_t>(std::ranges::count_if(
      submaps_, [&](const Submap& submap) { return !submap.members.empty() && AnchorOf(submap, poses) == nullptr; }));
}

/// Moves the content of a submap to another one.
void DenseMap::Join(Submap& gone, const SE3& T_to_gone, Submap& to) const {
  const Voxels moving(gone, voxel_m_);
  if (to.growing) {
    to.growing->Add(*moving, T_to_gone);
  } else {
    Volume joined = to.packed.Unpack(voxel_m_);
    joined.Add(*moving, T_to_gone);
    to.packed = PackedVolume(joined);
  }
  for (const BoundedView& view : gone.views) {
    BoundedView& moved = to.views.emplace_back();
    moved.submap = view.submap;
    moved.ends.reserve(view.ends.size());
    moved.eye = (T_to_gone * view.eye.cast<double>()).cast<float>();
    for (const Eigen::Vector3f& end : view.ends) moved.ends.push_back((T_to_gone * end.cast<double>()).cast<float>());
  }
  std::ranges::stable_sort(to.views, {}, &BoundedView::submap);
  if (to.views.size() > kMostViews) to.views.erase(to.views.begin(), to.views.end() - kMostViews);
  Empty(gone);
}

void DenseMap::Empty(Submap& gone) {
  gone.members.clear();
  gone.packed = {};
  gone.views.clear();
}

void DenseMap::FollowRemovals(const KeyframePoses& poses, const KeyframePoses& lasting, const StereoCamera& camera) {
  std::map<KeyframeFrame, Submap*> submap_of;  // of lasting keyframes
  std::vector<Submap*> left;                   // submaps without one
  for (Submap& submap : submaps_) {
    bool lasts = &submap == &submaps_.back() || submap.members.empty();
    for (const auto& [keyframe, T_s_kf] : submap.members) {
      // A keyframe that is neither in the map nor removed will arrive: the map is being rebuilt.
      if (lasting.contains(keyframe)) submap_of[keyframe] = &submap;
      if (lasting.contains(keyframe) || !poses.contains(keyframe)) lasts = true;
    }
    if (!lasts) left.push_back(&submap);
  }
  for (Submap* const submap : left) {
    const std::optional<SE3> T_w_s = PoseOf(*submap, poses);
    if (!T_w_s) continue;
    std::vector<Eigen::Vector3d> surface_w = SampleSurface(*Voxels(*submap, voxel_m_));
    for (Eigen::Vector3d& p : surface_w) p = *T_w_s * p;
    const SeenSurface seen = SeenBy(lasting, camera, RangeOf(camera, voxel_m_), surface_w);
    if (seen.share < kLeastSeen) {
      Empty(*submap);
      continue;
    }
    const KeyframeFrame* most = nullptr;
    for (const auto& [keyframe, n] : seen.n_points) {
      if (submap_of.contains(keyframe) && (most == nullptr || n > seen.n_points.at(*most))) most = &keyframe;
    }
    // The depth of those that see it may not have been received.
    if (most == nullptr) continue;
    Submap& to = *submap_of.at(*most);
    if (const std::optional<SE3> T_w_to = PoseOf(to, poses)) Join(*submap, T_w_to->Inverse() * *T_w_s, to);
  }
}

Volume DenseMap::Merge(const KeyframePoses& poses, const SE3& T_a_w) const {
  std::vector<std::optional<SE3>> T_a_submap;
  std::vector<std::vector<std::pair<const BoundedView*, SE3>>> views_of(submaps_.size());
  for (const Submap& submap : submaps_) {
    std::optional<SE3> T_a_s = PoseOf(submap, poses);
    if (T_a_s) {
      *T_a_s = T_a_w * *T_a_s;
      for (const BoundedView& view : submap.views) views_of[view.submap].emplace_back(&view, *T_a_s);
    }
    T_a_submap.push_back(T_a_s);
  }
  // In the order of time: a bound proves nothing about later obstacles.
  Volume merged(voxel_m_);
  for (size_t i = 0; i < submaps_.size(); ++i) {
    if (T_a_submap[i]) merged.Add(*Voxels(submaps_[i], voxel_m_), *T_a_submap[i]);
    for (const auto& [view, T_a_s] : views_of[i]) {
      std::vector<Eigen::Vector3d> ends;
      for (const Eigen::Vector3f& end : view->ends) ends.push_back(T_a_s * end.cast<double>());
      merged.Clear(T_a_s * view->eye.cast<double>(), ends);
    }
  }
  return merged;
}

SurfaceCloud DenseMap::Split(const Surface& surface_w, const KeyframePoses& poses) const {
  SurfaceCloud cloud;
  cloud.voxel_m = voxel_m_;
  std::vector<const Surface::Vertex*> left;
  for (const Surface::Vertex& vertex : surface_w.vertices) left.push_back(&vertex);
  const auto add = [](const Surface::Vertex& vertex, const SE3& T_anchor_w, SubmapCloud& to) {
    to.points.push_back({(T_anchor_w * vertex.p.cast<double>()).cast<float>(),
                         RoundedNormal((T_anchor_w.R() * vertex.normal.cast<double>()).cast<float>()), vertex.grey});
  };
  for (size_t i = 0; i < submaps_.size(); ++i) {
    const Member* const anchor = AnchorOf(submaps_[i], poses);
    if (anchor == nullptr) continue;
    const SE3& T_w_anchor = poses.at(anchor->keyframe);
    const SE3 T_anchor_w = T_w_anchor.Inverse();
    SubmapCloud& to = cloud.submaps[static_cast<int>(i)];
    to = {anchor->keyframe.first, anchor->keyframe.second, T_w_anchor, {}};
    const Voxels voxels(submaps_[i], voxel_m_);
    const Volume::Reader reader(*voxels);
    const SE3 T_s_w = anchor->T_s_kf * T_anchor_w;
    std::erase_if(left, [&](const Surface::Vertex* vertex) {
      const Eigen::Vector3d p = T_s_w * vertex->p.cast<double>() / voxel_m_;
      const auto voxel = reader.At({static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())),
                                    static_cast<int>(std::lround(p.z()))});
      const bool is_known =
          voxel && voxel->weight >= kLeastKnown && std::abs(voxel->distance_m) < kSameSurface * voxel_m_;
      if (is_known) add(*vertex, T_anchor_w, to);
      return is_known;
    });
  }
  if (cloud.submaps.empty()) return cloud;
  SubmapCloud& newest = cloud.submaps.rbegin()->second;
  for (const Surface::Vertex* vertex : left) add(*vertex, newest.T_w_anchor.Inverse(), newest);
  return cloud;
}

void DenseMap::Write(const std::string& path, const KeyframePoses& poses, const KeyframePoses& lasting) const {
  std::vector<StoredSubmap> stored;
  for (const Submap& submap : submaps_) {
    StoredSubmap& to = stored.emplace_back();
    if (submap.members.empty()) continue;
    to = {submap.members, {}, submap.packed, {}};
    if (submap.growing) to.blocks = submap.growing->Blocks();
    for (const BoundedView& view : submap.views) {
      std::vector<float>& numbers = to.views.emplace_back(StoredSubmap::View{view.submap, {}}).numbers;
      numbers.assign(view.eye.begin(), view.eye.end());
      for (const Eigen::Vector3f& end : view.ends) numbers.insert(numbers.end(), end.begin(), end.end());
    }
    // Removed keyframes are unknown to the map that continues.
    std::erase_if(to.members, [&](const Member& member) {
      return poses.contains(member.keyframe) && !lasting.contains(member.keyframe);
    });
    if (!to.members.empty()) continue;
    const SE3 T_w_s = *PoseOf(submap, poses);
    const std::optional<KeyframeFrame> nearest = NearestKeyframe(lasting, T_w_s * submap.members.front().T_s_kf);
    if (nearest) {
      to.members.push_back({*nearest, T_w_s.Inverse() * lasting.at(*nearest)});
    } else {
      to = {};
    }
  }
  const std::vector<KeyframeFrame> fused(fused_.begin(), fused_.end());
  WriteSealedFile(path, kSurfaces, archive::ToBytes(voxel_m_, robot_, fused, stored));
}

DenseMap DenseMap::Read(const std::string& path, double range_m) {
  const std::vector<uint8_t> bytes = ReadSealedFile(path, kSurfaces);
  return NamingFile(path, [&] {
    double voxel_m = 0.0;
    Robot robot;
    std::vector<KeyframeFrame> fused;
    std::vector<StoredSubmap> stored;
    archive::FromBytes(bytes, voxel_m, robot, fused, stored);
    if (!(voxel_m > 0.0 && voxel_m <= kLargestVoxel_m))
      throw std::runtime_error("the size of its voxels is impossible");
    DenseMap map(voxel_m, range_m);
    map.SetRobot(std::move(robot));
    map.fused_.insert(fused.begin(), fused.end());
    for (const StoredSubmap& submap : stored) {
      const bool are_poses = std::ranges::all_of(submap.members, [](const Member& member) {
        return member.T_s_kf.IsFinite() && std::abs(member.T_s_kf.rotation().norm() - 1.0) < kUnit;
      });
      if (!are_poses) throw std::runtime_error("a submap has no valid pose");
      Submap& read = map.submaps_.emplace_back(Submap{submap.members, {}, submap.packed, {}});
      submap.packed.Unpack(voxel_m);  // throws for impossible values
      if (&submap == &stored.back()) read.growing = Volume::FromBlocks(voxel_m, submap.blocks);
      for (const auto& [submap_of_view, numbers] : submap.views) {
        const bool are_points = numbers.size() >= 3 && numbers.size() % 3 == 0 &&
                                std::ranges::all_of(numbers, [](float x) { return std::abs(x) < kFarthest_m; });
        if (!are_points || submap_of_view >= stored.size()) throw std::runtime_error("a submap has invalid rays");
        BoundedView& view = read.views.emplace_back();
        view.submap = submap_of_view;
        view.eye = Eigen::Vector3f(numbers.data());
        for (size_t i = 3; i < numbers.size(); i += 3) view.ends.emplace_back(numbers.data() + i);
      }
    }
    return map;
  });
}

}  // namespace plslam::dense
