// Renderers and pushes for the tests.
#pragma once

#include <vector>

#include "enamel/device/tau/mechanism.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/push.hpp"
#include "enamel/sim/simulated_device.hpp"
#include "support/devices.hpp"
#include "support/reference.hpp"

namespace enamel::test {

/// Return the gain of data/reference/servo-nominal.json: designed for the nominal device at 1 ms.
ServoGain referenceGain();

HoldRenderer holdRenderer(const HoldOptions& options = {});

/// Return position control for a mechanism with a delay of `low` to `high` ticks.
PositionControlRenderer positionControl(const Mechanism& mechanism, int low = 0, int high = 0);

HoldOptions asInThePaper();

/// Return the plant of the impedance scenarios: 4 N s/m of mechanical damping on the TCP along z.
TauParameters dampedNominal();

/// Return the push of a row of data/reference/runs-nominal.json.
PushSetup referenceSetup(const ReferenceRun& run);

/// Return a hand that pulls the TCP to (0, 0, z), m, and keeps the orientation: N/m, N s/m.
WrenchFunction handAt(double z, double stiffness, double damping);

std::vector<TickRecord> recordPush(const Mechanism& plant, Renderer& renderer, const PushSetup& setup);

/// Return a valid input of a renderer at a pose, with the TCP's contact with the wall z = 0.
TickFrame frameAt(const Mechanism& mechanism, const Pose& pose, double time, const Vec6& twist = Vec6::Zero());

Pose poseAtDepth(double depth);

}  // namespace enamel::test
