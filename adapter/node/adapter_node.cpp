// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/adapter_node.h"

#include "core/bus/run_loop.h"
#include "core/geometry/body_frame.h"

namespace plslam::adapter {
namespace {

constexpr const char* kUrlOption = "adapter.foreign_url";
constexpr int kWait_ms = 100;

}  // namespace

AdapterNode::AdapterNode(bus::Process& process, const AdapterOptions& options)
    : process_(process),
      images_lcm_(options.foreign_url, kUrlOption),
      poses_lcm_(options.foreign_url, kUrlOption),
      maps_lcm_(options.foreign_url, kUrlOption),
      poses_(process, poses_lcm_, options),
      map_(options.map.empty() ? nullptr : std::make_unique<MapSink>(process, maps_lcm_, options.map)),
      images_(process, images_lcm_, options,
              {.on_rig = [this](const RigCalibration& rig) { SetBody(BodyFromCamera(rig)); },
               .on_frame = [this](int64_t t_ns) { poses_.OnFrame(t_ns); }}),
      motions_(options.robot_odometry.empty()
                   ? nullptr
                   : std::make_unique<MotionSource>(process, images_lcm_, options.robot_odometry,
                                                    [this] { return images_.n_sent(); })) {
  AdapterOptions shown = options;
  process_.SetConfiguration(ToYaml("adapter", shown));
  listener_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { Listen(); }); });
  worker_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { images_.Work(); }); });
}

AdapterNode::~AdapterNode() {
  stopped_ = true;
  images_.Stop();
  listener_.join();
  worker_.join();
}

void AdapterNode::SetBody(const SE3& T_b_c) {
  poses_.SetBody(T_b_c);
  if (map_) map_->SetBody(T_b_c);
}

void AdapterNode::Listen() {
  while (!stopped_) {
    if (!images_lcm_.Handle(kWait_ms)) return process_.Finish();
    process_.SetCounter("messages.lost", static_cast<double>(images_lcm_.lost()));
  }
}

}  // namespace plslam::adapter
