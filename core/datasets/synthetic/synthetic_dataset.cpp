// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/synthetic_dataset.h"

#include "core/datasets/synthetic/simulator.h"

namespace plslam {
namespace {

class SyntheticDataset : public Dataset {
 public:
  explicit SyntheticDataset(const std::string& description)
      : name_("synthetic:" + description), simulator_(synthetic::ParseOptions(description)) {}

  std::string name() const override { return name_; }
  const RigCalibration& rig() const override { return simulator_.rig(); }
  int size() const override { return simulator_.size(); }
  int64_t t_ns(int index) const override { return simulator_.t_ns(index); }
  StereoImages Read(int index) const override { return simulator_.Render(index); }
  std::optional<SE3> GroundTruth(int index) const override { return simulator_.T_w_c(index); }

 private:
  std::string name_;
  synthetic::Simulator simulator_;
};

}  // namespace

std::unique_ptr<Dataset> OpenSyntheticDataset(const std::string& description) {
  return std::make_unique<SyntheticDataset>(description);
}

}  // namespace plslam
