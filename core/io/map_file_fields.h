#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "core/features/features.h"
#include "core/io/map_file.h"

// The fields of everything in a map file, in their order there: one list for writing and for reading.
namespace plslam::map_file {

static_assert(std::endian::native == std::endian::little, "map files are copied byte by byte");

template <class T, class Of>
concept Is = std::same_as<std::remove_const_t<T>, Of>;

template <class Archive, Is<StoredSession> T>
void Fields(Archive& a, T& session) {
  a(session.keyframe_id, session.session_keyframe_id);
}

template <class Archive, Is<MapKeyframe> T>
void Fields(Archive& a, T& k) {
  a(k.id, k.session, k.session_keyframe_id, k.frame_id, k.t_ns, k.T_w_kf, k.covariance, k.T_odom_kf, k.previous_id,
    k.T_prevkf_kf, k.relative_covariance, k.parent_id);
}

template <class Archive, Is<StereoPoint> T>
void Fields(Archive& a, T& p) {
  a(p.left.px, p.left.response, p.left.angle_rad, p.left.octave, p.left.descriptor, p.left.scale, p.disparity_px,
    p.sigma_px, p.sigma_disparity_px);
}

template <class Archive, Is<StereoLine> T>
void Fields(Archive& a, T& l) {
  a(l.left.segment.p, l.left.segment.q, l.left.response, l.left.octave, l.left.descriptor, l.disparity_p_px,
    l.disparity_q_px, l.sigma_px, l.sigma_disparity_p_px, l.sigma_disparity_q_px);
}

template <class Archive, Is<StereoFeatures> T>
void Fields(Archive& a, T& features) {
  a(features.points, features.lines);
}

template <class Archive, Is<Sight> T>
void Fields(Archive& a, T& sight) {
  a(sight.keyframe_id, sight.feature);
}

template <class Archive, Is<MapPoint> T>
void Fields(Archive& a, T& p) {
  a(p.id, p.p_w, p.covariance, p.descriptor, p.angle_rad, p.octave, p.depth_m, p.sights);
}

template <class Archive, Is<MapLine> T>
void Fields(Archive& a, T& l) {
  a(l.id, l.segment_w.p, l.segment_w.q, l.covariance_p, l.covariance_q, l.descriptor, l.sights);
}

template <class Archive, Is<LoopEdge> T>
void Fields(Archive& a, T& loop) {
  a(loop.old_keyframe_id, loop.keyframe_id, loop.T_old_kf, loop.covariance, loop.n_points, loop.n_lines);
}

/// All of a stored map but what it has many of.
template <class Archive, Is<StoredMap> T>
void Fields(Archive& a, T& stored) {
  a(stored.version, stored.rig, stored.next_keyframe_id, stored.next_point_id, stored.next_line_id,
    stored.newest_session, stored.newest_t_ns);
}

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::same_as<T, Descriptor> ||
    (requires { T::SizeAtCompileTime; } && T::SizeAtCompileTime != Eigen::Dynamic);

class Writer {
 public:
  explicit Writer(size_t expected_bytes = 0) { bytes_.reserve(expected_bytes); }

  template <class... T>
  void operator()(const T&... values) {
    (Write(values), ...);
  }

  std::vector<uint8_t> Take() && { return std::move(bytes_); }

 private:
  template <Plain T>
  void Write(const T& value) {
    const auto* const data = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), data, data + sizeof(T));
  }
  void Write(const SE3& pose) { (*this)(pose.translation(), pose.rotation().coeffs()); }
  template <class T>
  void Write(const std::vector<T>& values) {
    Write(static_cast<uint64_t>(values.size()));
    for (const T& value : values) Write(value);
  }
  template <class T>
  void Write(const T& value) {
    Fields(*this, value);
  }

  std::vector<uint8_t> bytes_;
};

class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  template <class... T>
  void operator()(T&... values) {
    (Read(values), ...);
  }

  /// How many follow, each of at least `min_bytes`.
  uint64_t ReadCount(size_t min_bytes) {
    uint64_t n = 0;
    Read(n);
    if (n > bytes_.size() / min_bytes) throw std::runtime_error("the content promises more than it has");
    return n;
  }

  bool AtEnd() const { return bytes_.empty(); }

 private:
  template <Plain T>
  void Read(T& value) {
    if (bytes_.size() < sizeof(T)) throw std::runtime_error("the content ends too early");
    std::memcpy(static_cast<void*>(&value), bytes_.data(), sizeof(T));
    bytes_ = bytes_.subspan(sizeof(T));
  }
  void Read(SE3& pose) {
    Eigen::Vector3d t;
    Eigen::Vector4d xyzw;
    (*this)(t, xyzw);
    pose = SE3::FromUnit(Eigen::Quaterniond(xyzw), t);
  }
  template <class T>
  void Read(std::vector<T>& values);
  template <class T>
  void Read(T& value) {
    Fields(*this, value);
  }

  std::span<const uint8_t> bytes_;
};

/// Bytes of a value whose vectors are empty.
template <class T>
size_t MinBytes() {
  static const size_t bytes = [] {
    Writer writer;
    writer(T());
    return std::move(writer).Take().size();
  }();
  return bytes;
}

template <class T>
void Reader::Read(std::vector<T>& values) {
  values.resize(ReadCount(MinBytes<T>()));
  for (T& value : values) Read(value);
}

}  // namespace plslam::map_file
