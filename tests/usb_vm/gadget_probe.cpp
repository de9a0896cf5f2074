// SPDX-License-Identifier: Apache-2.0
#include "tests/usb_vm/gadget_probe.hpp"

#include <chrono>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight::test {

namespace {

std::chrono::steady_clock::time_point time_point(std::int64_t at_ns) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(at_ns));
}

}  // namespace

Result<std::unique_ptr<GadgetProbe>> GadgetProbe::create(const Config& config) {
  auto script = FaultScript::parse(config.faults);
  if (!script) return script.error();
  auto model = ProbeModel::create(config.model);
  if (!model) return model.error();
  auto gadget = ConfigfsGadget::create(config.model.serial);
  if (!gadget) return gadget.error();
  auto function = FunctionFs::mount(ConfigfsGadget::kFunction);
  if (!function) return function.error();
  auto writes = BulkWrites::open(function->endpoint_path());
  if (!writes) return writes.error();
  auto core = std::make_unique<ProbeCore>(std::move(*model));
  core->script = std::move(*script);
  return std::unique_ptr<GadgetProbe>(
      new GadgetProbe(std::move(core), std::move(*gadget), std::move(*function), std::move(*writes)));
}

GadgetProbe::GadgetProbe(std::unique_ptr<ProbeCore> core, ConfigfsGadget gadget, FunctionFs function,
                         std::unique_ptr<BulkWrites> writes)
    : core_(std::move(core)),
      function_(std::move(function)),
      writes_(std::move(writes)),
      gadget_(std::move(gadget)),
      control_([this](const std::stop_token& stop) { serve_control(stop); }),
      pipe_([this](const std::stop_token& stop) { serve_pipe(stop); }),
      follower_([this](const std::stop_token& stop) { follow_script(stop); }) {}

GadgetProbe::~GadgetProbe() {
  unplug();
}

std::int64_t GadgetProbe::plug() {
  const std::lock_guard lock(core_->mutex);
  return plug_locked();
}

std::int64_t GadgetProbe::unplug() {
  const std::lock_guard lock(core_->mutex);
  return unplug_locked();
}

std::int64_t GadgetProbe::plug_locked() {
  const std::int64_t told_ns = now_ns();
  if (!gadget_.plug()) return 0;
  if (!std::exchange(script_began_, true)) {
    core_->script.begin(now_ns());
    core_->changed.notify_all();
  }
  return told_ns;
}

std::int64_t GadgetProbe::unplug_locked() {
  const std::int64_t told_ns = now_ns();
  // The kernel first: the host must lose the probe with pending writes and reads.
  gadget_.unplug();
  core_->model->advance(now_ns());
  core_->model->unplugged();
  core_->of_next_transfer.reset();
  end_stream();
  return told_ns;
}

void GadgetProbe::inject(const Fault& fault) {
  const std::lock_guard lock(core_->mutex);
  core_->carry_out(fault, now_ns());
  fulfil_plug_wish();
  pipe_bell_.ring();
}

ProbeModel::Counters GadgetProbe::counters() {
  const std::lock_guard lock(core_->mutex);
  return core_->model->counters();
}

void GadgetProbe::fulfil_plug_wish() {
  const auto wish = std::exchange(core_->plug_wish, std::nullopt);
  if (!wish) return;
  unplug_locked();
  if (wish == FaultKind::kReplug) plug_locked();
}

void GadgetProbe::follow_script(const std::stop_token& stop) {
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
    if (!faults.empty()) pipe_bell_.ring();
    if (core_->plug_wish) continue;
    if (const auto next_ns = core_->script.next_ns()) {
      core_->changed.wait_until(lock, time_point(*next_ns));
    } else {
      core_->changed.wait(lock);
    }
  }
}

}  // namespace fanlight::test
