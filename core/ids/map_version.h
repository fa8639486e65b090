// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <cstdint>

#include "core/ids/ids.h"

namespace plslam {

/// A map until another one replaces it.
///
/// Sessions and keyframes without a known map have the initial value: they have used no landmarks of any map, and
/// belong to one that has not replaced another.
struct MapId {
  /// The mapping_process with which it began. None: it keeps no state, and the next one rebuilds the map from the
  /// histories of other processes.
  SourceId origin;
  /// Number of maps that orders ("load", "reset") have replaced since.
  int64_t n_replaced = 0;

  friend auto operator<=>(const MapId&, const MapId&) = default;  // NOLINT(modernize-use-nullptr)

  /// Whether both are the same map; an unknown origin may be any.
  bool Matches(const MapId& other) const { return IsOfOrigin(other) && n_replaced == other.n_replaced; }
  /// Whether this map has replaced `other`.
  bool Supersedes(const MapId& other) const { return IsOfOrigin(other) && n_replaced > other.n_replaced; }
  /// Returns the map that replaces this one.
  MapId Next() const { return {origin, n_replaced + 1}; }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.origin, self.n_replaced);
  }

 private:
  bool IsOfOrigin(const MapId& other) const {
    return origin == other.origin || origin == SourceId() || other.origin == SourceId();
  }
};

/// A version of a map, as loop closures, answers and relocalisations name the map from which they were computed.
struct MapVersion {
  MapId map;
  /// The mapping_process that assigned the ids of keyframes and landmarks. Another one may assign others, and its
  /// numbers of versions cannot be compared with these.
  SourceId numbering;
  int64_t number = 0;  ///< 1, 2, 3, ...

  friend auto operator<=>(const MapVersion&, const MapVersion&) = default;  // NOLINT(modernize-use-nullptr)

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.map, self.numbering, self.number);
  }
};

}  // namespace plslam
