#include "design_file.hpp"

#include "json_matrices.hpp"

namespace enamel::app {

std::string jsonOf(const DesignedServo& servo) {
  const ServoDesign& design = servo.design;
  const ServoWeights& w = design.weights;
  Json out;
  out["note"] =
      "Linear model at the operating point, state y=[qdot;q-q0], input torque minus gravity torque; augmented with "
      "xi' = r - q, zero-order hold, LQR with Q=diag(velocity I, position I, integral I), R=torque I; "
      "u = -K [qdot; q-q0; xi]. Poles in rad/s, delays in samples; null means infinite.";
  out["model"] = servo.model;
  out["position"] = listOf(servo.position);
  out["device_damping"] = servo.deviceDamping;
  out["period"] = design.period;
  out["weights"] = {{"velocity", w.velocity}, {"position", w.position}, {"integral", w.integral}, {"torque", w.torque}};
  out["linearisation_error"] = servo.linearisationError;
  out["q0"] = listOf(servo.plant.joints);
  out["gravity_torque"] = listOf(servo.plant.u0);
  out["A"] = rowsOf(design.plant.A);
  out["B"] = rowsOf(design.plant.B);
  out["Ad"] = rowsOf(design.augmented.A);
  out["Bd"] = rowsOf(design.augmented.B);
  out["K"] = rowsOf(design.K);
  out["P"] = rowsOf(design.P);
  out["spectral_radius"] = servo.spectralRadius;
  out["poles"] = Json::array();
  for (const auto& pole : servo.poles) out["poles"].push_back({pole.real(), pole.imag()});
  Json& margins = out["margins"];
  margins["disk"] = servo.margins.disk;
  margins["disk_frequency"] = servo.margins.diskFrequency;
  margins["tolerated_delay"] = servo.margins.toleratedDelay;
  margins["spectral_radius_beyond"] = servo.margins.radiusBeyond;
  margins["inputs"] = Json::array();
  for (const ChannelMargins& c : servo.margins.channel)
    margins["inputs"].push_back({{"gain_up", c.gainUp}, {"gain_down", c.gainDown}, {"phase", c.phase}});
  out["requirements"] = Json::array();
  for (const Requirement& r : servo.requirements)
    out["requirements"].push_back({{"name", r.name},
                                   {"unit", r.unit},
                                   {"limit", r.limit},
                                   {"values", r.values},
                                   {"worst", r.worst()},
                                   {"met", r.met()}});
  return textOf(out);
}

}  // namespace enamel::app
