// Record a loop and replay it: the same renderer gives the same bits, and another one shows its own answer.
//
//   record tau-nominal.toml out.rec         (the file must not exist)
#include <cstdio>
#include <enamel/core/error.hpp>
#include <enamel/core/file.hpp>
#include <enamel/device/device_file.hpp>
#include <enamel/render/impedance.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/runtime/recorder.hpp>
#include <enamel/runtime/replay.hpp>
#include <enamel/sim/hand.hpp>
#include <enamel/sim/virtual_device.hpp>

using namespace enamel;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: record DEVICE.toml OUT.rec\n"), 2;
  try {
    constexpr double kPeriod = 1e-3;  // s
    const auto mechanism = makeMechanism(idealOf(loadDevice(argv[1])));
    const Scene scene = flatWall();
    VirtualDeviceSetup setup;
    setup.start.position.z() = 0.002;
    setup.encoders.quantised = true;
    VirtualDevice device(*mechanism, setup);
    const PositionControlOptions options = positionControlFor(*mechanism, kPeriod, 0, 0);
    PositionControlRenderer servo(options);
    HapticTick tick(*mechanism, scene, Tool(), servo, kPeriod, setup.start);

    RecordingHeader header;  // lets `enamel replay` and the viewer build the tick again
    header.deviceFile = argv[1];
    header.deviceText = readFile(argv[1]);
    header.renderer = "position-control";
    header.parameters = {{"drive", "ideal"}};  // this virtual device has ideal drives
    header.start = setup.start;
    Recorder recorder(argv[2], header, tick);  // in a HapticLoop: HapticLoopOptions::sink

    const auto hand = [&](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = guidingWrench(pose, twist, setup.start, Vec3::UnitZ());
      wrench.z() -= 2.0 + 3.0 * twist.z();
      return wrench;
    };
    Measurement measurement;
    Command command;
    for (std::uint64_t i = 0; i < 2000; ++i) {
      if (device.measure(measurement) != Status::ok) return 1;
      const Status status = tick(measurement, command);
      recorder.add(i, measurement, tick, command, status);
      recorder.makeRoom();  // a simulation can wait for the disk; a loop with a person must not
      if (device.actuate(command) != Status::ok || device.advance(hand) != Status::ok) return 1;
    }
    const RecordingResult written = recorder.close();
    std::printf("%s: %llu ticks, %llu lost\n", argv[2], static_cast<unsigned long long>(written.ticks),
                static_cast<unsigned long long>(written.lost));

    // Replay from the file alone: the device of the header and a new instance of the same servo.
    RecordingReader reader(argv[2]);
    const auto recorded = makeMechanism(parseDevice(reader.header().deviceText, reader.header().deviceFile));
    PositionControlRenderer same(options);
    ImpedanceRenderer other({6000.0, 0.0});  // N/m, N s/m
    const auto compare = [&](Renderer& renderer, const char* name) {
      HapticTick again(*recorded, scene, Tool(), renderer, reader.header().guard, reader.header().start);
      const ReplayResult result = replay(reader, again);
      std::printf("%-16s %llu of %llu ticks differ, in the command by up to %.3g N m\n", name,
                  static_cast<unsigned long long>(result.different), static_cast<unsigned long long>(result.ticks),
                  result.command.size() > 0 ? result.command.maxCoeff() : 0.0);
      return result.different;
    };
    return compare(same, "position control") == 0 && compare(other, "spring") > 0 ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "record: %s\n", error.what());
    return 1;
  }
}
