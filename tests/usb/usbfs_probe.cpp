// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/usbfs_probe.hpp"

#include <chrono>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight::test {

namespace {

std::chrono::steady_clock::time_point time_point(std::int64_t at_ns) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(at_ns));
}

}  // namespace

Result<std::unique_ptr<UsbfsProbe>> UsbfsProbe::create(EmulatedBus& bus, const Config& config) {
  auto script = FaultScript::parse(config.faults);
  if (!script) return script.error();
  auto model = ProbeModel::create(config.model);
  if (!model) return model.error();
  auto core = std::make_shared<ProbeCore>(std::move(*model));
  core->script = std::move(*script);
  return std::unique_ptr<UsbfsProbe>(new UsbfsProbe(bus, std::move(core)));
}

UsbfsProbe::UsbfsProbe(EmulatedBus& bus, std::shared_ptr<ProbeCore> core)
    : bus_(bus),
      core_(std::move(core)),
      port_(bus.new_port()),
      follower_([this](std::stop_token stop) { follow_script(std::move(stop)); }) {}

UsbfsProbe::~UsbfsProbe() {
  follower_.request_stop();
  follower_.join();
  unplug();
}

void UsbfsProbe::plug() {
  const std::lock_guard lock(core_->mutex);
  plug_locked();
}

void UsbfsProbe::unplug() {
  const std::lock_guard lock(core_->mutex);
  unplug_locked();
}

bool UsbfsProbe::plugged() {
  const std::lock_guard lock(core_->mutex);
  return device_ != nullptr;
}

void UsbfsProbe::plug_locked() {
  if (device_ != nullptr) return;
  device_ = std::make_shared<UsbfsDevice>(core_);
  place_ = bus_.plug(port_, core_->model->config().serial, device_->handler().get());
  if (std::exchange(script_began_, true)) return;
  core_->script.begin(now_ns());
  core_->changed.notify_all();
}

void UsbfsProbe::unplug_locked() {
  if (device_ == nullptr) return;
  device_->gone();
  device_.reset();
  core_->model->advance(now_ns());
  core_->model->unplugged();
  core_->halted = false;
  core_->of_next_transfer.reset();
  bus_.unplug(place_);
}

void UsbfsProbe::inject(const Fault& fault) {
  const std::lock_guard lock(core_->mutex);
  core_->carry_out(fault, now_ns());
  if (device_ != nullptr) device_->wake();
}

ProbeModel::Counters UsbfsProbe::counters() {
  const std::lock_guard lock(core_->mutex);
  return core_->model->counters();
}

std::uint64_t UsbfsProbe::waiting() {
  const std::lock_guard lock(core_->mutex);
  return core_->model->waiting();
}

bool UsbfsProbe::streaming() {
  const std::lock_guard lock(core_->mutex);
  return core_->model->streaming();
}

std::uint64_t UsbfsProbe::carried_out(FaultKind kind) {
  const std::lock_guard lock(core_->mutex);
  return core_->carried_out[static_cast<std::size_t>(kind)];
}

void UsbfsProbe::fulfil_plug_wish() {
  const auto wish = std::exchange(core_->plug_wish, std::nullopt);
  if (!wish) return;
  unplug_locked();
  if (wish == FaultKind::kReplug) plug_locked();
}

void UsbfsProbe::follow_script(std::stop_token stop) {
  const std::stop_callback wake_up(stop, [this] {
    const std::lock_guard lock(core_->mutex);
    core_->changed.notify_all();
  });
  std::unique_lock lock(core_->mutex);
  while (!stop.stop_requested()) {
    fulfil_plug_wish();
    const auto faults = core_->script.due(now_ns());
    for (const Fault& fault : faults) {
      core_->carry_out(fault, now_ns());
      fulfil_plug_wish();
    }
    if (!faults.empty() && device_ != nullptr) device_->wake();
    if (core_->plug_wish) continue;
    if (const auto next_ns = core_->script.next_ns()) {
      core_->changed.wait_until(lock, time_point(*next_ns));
    } else {
      core_->changed.wait(lock);
    }
  }
}

}  // namespace fanlight::test
