// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <vector>

#include <fmt/format.h>

namespace plslam {

/// A 64-bit id that no id of another kind can take the place of. `Kind::kNone` is the value of no element, and the
/// initial one.
///
/// Constants of type int convert, so that `id < 0` and `{.session = 7}` can be written; other integers must be
/// converted explicitly, as when a message is decoded. Messages and files store `value`.
template <class Kind>
struct Id {
  int64_t value = Kind::kNone;

  constexpr Id() = default;
  template <std::same_as<int> T>
  constexpr Id(T constant) : value(constant) {}  // NOLINT(google-explicit-constructor): see above.
  template <std::integral T>
  requires(!std::same_as<T, int>) constexpr explicit Id(T id) : value(static_cast<int64_t>(id)) {}

  friend constexpr auto operator<=>(const Id&, const Id&) = default;  // NOLINT(modernize-use-nullptr)
  /// The next id that is assigned.
  constexpr Id& operator++() {
    ++value;
    return *this;
  }
  constexpr Id operator++(int) {
    const Id id = *this;
    ++value;
    return id;
  }

  friend std::ostream& operator<<(std::ostream& to, const Id& id) { return to << id.value; }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.value);
  }
};

struct SessionKind {
  static constexpr int64_t kNone = 0;
};
/// An odometry session: keyframes and frames between two restarts of tracking, or two maps. A random number.
using SessionId = Id<SessionKind>;

struct SourceKind {
  static constexpr int64_t kNone = 0;
};
/// A process that publishes or reads, from its start to its end (`header_t.source`). A random number; 0: none, or all.
using SourceId = Id<SourceKind>;

struct FrameKind {
  static constexpr int64_t kNone = -1;
};
/// A frame of a stream: its number in the dataset, or 0, 1, 2, ... as a camera takes them; may repeat in another stream.
using FrameId = Id<FrameKind>;

struct KeyframeKind {
  static constexpr int64_t kNone = -1;
};
/// A keyframe of a map: 0, 1, 2, ... in the order of insertion, over all sessions; never assigned again.
using KeyframeId = Id<KeyframeKind>;

struct LandmarkKind {
  static constexpr int64_t kNone = -1;
};
/// A landmark of a map: 0, 1, 2, ... among points, and among lines; never assigned again.
using LandmarkId = Id<LandmarkKind>;

struct TrackKind {
  static constexpr int64_t kNone = -1;
};
/// A landmark of a tracker, which the map may know by another id: 0, 1, 2, ... among points, and among lines.
using TrackId = Id<TrackKind>;

/// A keyframe as every process can name it: by its session and its number there (0, 1, 2, ...; -1: none). The name
/// survives restarts, while a map that is rebuilt may assign other ids.
struct KeyframeName {
  SessionId session;
  int64_t number = -1;

  friend auto operator<=>(const KeyframeName&, const KeyframeName&) = default;  // NOLINT(modernize-use-nullptr)

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.session, self.number);
  }
};

/// Returns the numbers of ids, as messages have them.
template <class Kind>
std::vector<int64_t> Values(const std::vector<Id<Kind>>& ids) {
  std::vector<int64_t> values;
  values.reserve(ids.size());
  for (const Id<Kind>& id : ids) values.push_back(id.value);
  return values;
}

/// Returns the ids with these numbers.
template <class AnId>
std::vector<AnId> IdsFrom(const std::vector<int64_t>& values) {
  std::vector<AnId> ids;
  ids.reserve(values.size());
  for (const int64_t value : values) ids.push_back(AnId(value));
  return ids;
}

}  // namespace plslam

template <class Kind>
struct std::hash<plslam::Id<Kind>> {
  size_t operator()(const plslam::Id<Kind>& id) const noexcept { return std::hash<int64_t>()(id.value); }
};

template <class Kind>
struct fmt::formatter<plslam::Id<Kind>> : fmt::formatter<int64_t> {
  auto format(const plslam::Id<Kind>& id, fmt::format_context& context) const {
    return fmt::formatter<int64_t>::format(id.value, context);
  }
};
