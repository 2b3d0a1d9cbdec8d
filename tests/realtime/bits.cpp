// Prints a push with every renderer, with all digits. check.sh compares the output of different builds: it must be
// equal.
#include <cstdio>

#include "enamel/control/device_plant.hpp"
#include "support/pushes.hpp"

using namespace enamel;

namespace {

template <typename Vector>
void print(const Vector& v) {
  for (Eigen::Index i = 0; i < v.size(); ++i) std::printf(" %a", v.data()[i]);
}

}  // namespace

int main() {
  const auto nominal = std::make_shared<TauMechanism>(test::nominal());
  const TauMechanism damped(test::dampedNominal());
  HoldRenderer hold(designServo(nominal, Pose{}, 1e-3).K, 1e-3, {});
  PositionControlRenderer servo = test::positionControl(*nominal);
  ImpedanceRenderer spring({6000.0, 0.0});
  PushSetup setup;
  setup.encoders = {true, RateSource::lowPass, 100.0};
  setup.seed = 7;
  for (const auto& [plant, renderer] :
       {std::pair<const TauMechanism&, Renderer&>{*nominal, hold}, {*nominal, servo}, {damped, spring}})
    for (const TickRecord& tick : test::recordPush(plant, renderer, setup)) {
      print(tick.pose.position);
      print(tick.pose.rotation);
      print(tick.twist);
      print(tick.torque);
      std::puts("");
    }
}
