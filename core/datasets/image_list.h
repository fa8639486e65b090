// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/datasets/dataset.h"
#include "core/files/notes.h"
#include "core/io/images/image_file.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// Returns pairs of indices (a, b) of two increasing lists of times that are at most `max_ns` apart, each index at most
/// once, assigned in order of increasing distance (as in TUM's associate.py) and returned in order of a. For each a,
/// the nearest b before and after it are considered.
std::vector<std::pair<size_t, size_t>> AssociateTimes(const std::vector<int64_t>& a_ns,
                                                      const std::vector<int64_t>& b_ns, int64_t max_ns);

/// Reports `n` of `n_all` images (`what`: "images of cam0") without a partner `where` ("in time"), if there are any: a
/// warning if they are more than 5 %. Cameras that are started one after the other leave a few.
void NoteUnpaired(size_t n, size_t n_all, const std::string& what, const std::string& where, Notes* notes);

/// Returns the median step of increasing times; 1 s for fewer than two.
int64_t MedianStep_ns(const std::vector<int64_t>& times_ns);

/// A stereo sequence as a list of image files: the common form of all folder readers.
struct ImageList {
  struct Entry {
    int64_t t_ns = 0;
    std::string left;
    std::string right;  ///< depth map for RGB-D rigs
    /// The reason why there is no such pair, as a complete sentence; `Read` throws it. Empty: there is one.
    std::string missing;
  };
  std::string name;
  RigCalibration rig;
  ImageSize image_size;  ///< of the images themselves, by LearnImageSize
  std::vector<Entry> entries;
  /// Empty, or one for each entry.
  std::vector<std::optional<SE3>> ground_truth;
  /// Samples of the inertial sensor `rig.imu`, in order of increasing time.
  std::vector<ImuSample> imu_samples{};
  Notes notes;
};

/// Sets the rate from the median distance in time. Throws DatasetError where the list is empty, the times do not
/// increase (readers check that earlier, with the line), the rig is not valid (RigComplaint) or of another size than
/// the images; `calibration_path` is named then.
std::unique_ptr<Dataset> MakeImageListDataset(ImageList list, const std::string& calibration_path);

/// Returns the size of the images of the first pair whose headers can be read and agree. Throws the first pair's
/// DatasetError if there is no such pair.
ImageSize LearnImageSize(const std::vector<ImageList::Entry>& entries);

/// Returns the true pose of each entry of `list` by InterpolatePose, from the file at `path`. If fewer than half of the
/// frames get one, `list` gets a note with both spans of time: a warning if none does, or if most of the truth is of
/// times outside the sequence (different clocks), and a remark if a part of the sequence has truth.
std::vector<std::optional<SE3>> FrameTruth(const std::string& path, TrajectoryFormat format, ImageList* list);

}  // namespace plslam
