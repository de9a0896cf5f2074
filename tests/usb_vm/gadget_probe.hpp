#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "proto/doorbell.hpp"
#include "tests/usb/probe_core.hpp"
#include "tests/usb_vm/bulk_writes.hpp"
#include "tests/usb_vm/configfs_gadget.hpp"
#include "tests/usb_vm/function_fs.hpp"

namespace fanlight::test {

/// ProbeModel behind a real USB device controller, with the faults of a FaultScript and those that are
/// injected. What UsbfsProbe (tests/usb) is on an emulated bus this is on the kernel's own. It cannot make a
/// transfer fail or overflow: the faults error and overflow change nothing. The kernel holds up to a MiB of
/// frames that the host has not read yet; where they are taken back (stall, start, stop), or lost with the
/// plug, the model's counters have them as sent all the same. A value that the model does not take is
/// ignored and not stalled, see FunctionFs::take().
///
/// Life: created unplugged -> plug() -> unplug() -> plug() -> ... All functions from any thread.
class GadgetProbe {
 public:
  struct Config {
    ProbeModel::Config model;
    std::string faults;  ///< FaultScript, which begins with the first plug
  };
  /// kInvalidArgument where a value is out of its range or the script is not understood, kUnavailable where
  /// this machine cannot play a device.
  static Result<std::unique_ptr<GadgetProbe>> create(const Config& config);
  ~GadgetProbe();
  GadgetProbe(const GadgetProbe&) = delete;
  GadgetProbe& operator=(const GadgetProbe&) = delete;

  // Both return the moment just before the kernel was told, and come back when it has done so; nothing
  // happens where the probe is there, or not there, already.
  std::int64_t plug();  ///< 0 where the kernel refused
  std::int64_t unplug();

  /// What faults of a plug are is done before it returns.
  void inject(const Fault& fault);

  ProbeModel::Counters counters();

 private:
  GadgetProbe(std::unique_ptr<ProbeCore> core, ConfigfsGadget gadget, FunctionFs function,
              std::unique_ptr<BulkWrites> writes);

  std::int64_t plug_locked();
  std::int64_t unplug_locked();
  void fulfil_plug_wish();

  // One thread each.
  void follow_script(const std::stop_token& stop);
  void serve_control(const std::stop_token& stop);
  void serve_pipe(const std::stop_token& stop);

  void serve(const usb_ctrlrequest& request);
  void serve_in(const usb_ctrlrequest& request);
  void serve_out(const usb_ctrlrequest& request);
  bool wait_while_mute(const usb_ctrlrequest& request, const std::stop_token& stop);
  void end_stream();
  std::int64_t fill_pipe();
  void stall();

  const std::unique_ptr<ProbeCore> core_;
  // Under its lock, but for the events and answers of function_, which are the control thread's.
  FunctionFs function_;
  std::unique_ptr<BulkWrites> writes_;
  ConfigfsGadget gadget_;
  std::size_t begun_bytes_ = 0;     // of the next write: a transfer that has neither ended nor filled it
  bool owes_empty_packet_ = false;  // to end a transfer whose last packet was full
  bool script_began_ = false;

  Doorbell pipe_bell_;
  Doorbell control_bell_;
  std::jthread control_;  // these last, so that they end first
  std::jthread pipe_;
  std::jthread follower_;
};

}  // namespace fanlight::test
