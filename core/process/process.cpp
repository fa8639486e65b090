#include "core/process/process.h"

#include "core/process/process_impl.h"

namespace plslam::bus {

Process::Process(const std::string& name, const BusOptions& options)
    : name_(name), bus_(std::make_unique<Bus>(options, name)), impl_(std::make_unique<Impl>(name, options, *bus_)) {}

Process::~Process() = default;

void Process::SetState(const std::string& state, const std::string& reason) { impl_->status.SetState(state, reason); }

void Process::SetReason(const std::string& reason) { impl_->status.SetReason(reason); }

void Process::SetConfiguration(const std::string& yaml) { impl_->status.SetConfiguration(yaml); }

void Process::SetCounter(const std::string& name, double value) { impl_->status.SetCounter(name, value); }

void Process::Finish(int exit_code) {
  impl_->exit_code = exit_code;
  impl_->finished = true;
  bus_->Stop();
}

}  // namespace plslam::bus
