#pragma once

#include "core/geometry/stereo_camera.h"
#include "core/localisation/local_map.h"
#include "mapping_process/options.h"

namespace plslam {

/// Looks for a keyframe's landmarks in its neighbours and for the neighbours' landmarks in it (PL-SLAM §V.A), by
/// projection: a feature that shows none yet is one more sight; where it shows another landmark near by, the two are one.
void MergeWithNeighbours(int64_t keyframe_id, const KeyframeFeatures& features, const StereoCamera& camera,
                         const MappingOptions& options, Map& map);

}  // namespace plslam
