// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gst/gst.h>

#include <string>
#include <vector>

namespace plslam::test {

/// Returns the first of these elements of GStreamer that this machine does not have; empty if it has all.
inline std::string MissingElement(const std::vector<std::string>& names) {
  gst_init(nullptr, nullptr);
  for (const std::string& name : names) {
    GstElementFactory* factory = gst_element_factory_find(name.c_str());
    if (factory == nullptr) return name;
    gst_object_unref(factory);
  }
  return "";
}

}  // namespace plslam::test

/// Leaves the test, visibly skipped, where an element of GStreamer is missing.
#define PLSLAM_REQUIRE_ELEMENTS(...)                                                               \
  if (const std::string missing = plslam::test::MissingElement({__VA_ARGS__}); !missing.empty()) { \
    GTEST_SKIP() << "no GStreamer element " << missing                                             \
                 << " here: apt-get install gstreamer1.0-plugins-base gstreamer1.0-plugins-good";  \
  }                                                                                                \
  static_assert(true)
