// Prints two pushes, every number in full. The same program of another build must print the same: check.sh compares.
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
  const TauModel model = makeModel(test::nominal()), damped = makeModel(test::dampedNominal());
  PositionControlRenderer hold(model, designServo(model, Pose{}, 1e-3).K, 1e-3, {});
  ImpedanceRenderer spring(model, {6000.0, 0.0, 4.0});
  PushSetup setup;
  setup.encoders = {true, RateSource::lowPass, 100.0};
  setup.seed = 7;
  for (const auto& [plant, renderer] : {std::pair<const TauModel&, Renderer&>{model, hold}, {damped, spring}})
    for (const TickRecord& tick : test::recordPush(plant, renderer, setup)) {
      print(tick.pose.position);
      print(tick.pose.rotation);
      print(tick.twist);
      print(tick.torque);
      std::puts("");
    }
}
