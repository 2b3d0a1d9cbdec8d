// Uses the installed package: loads a shipped device, converts a pose to joints and back, and checks the layout of
// types.
#include <cstdio>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"

// The library's layout; a consumer with AVX-512 must agree.
static_assert(alignof(enamel::Mat6) == 16 && sizeof(enamel::Mat6) == 36 * sizeof(double), "layout of Mat6");

int main() {
  try {
    const enamel::TauModel model =
        enamel::makeModel(enamel::loadTau(ENAMEL_DATA_DIR "/devices/tau-nominal.toml"));
    enamel::Pose pose;
    pose.position = {0.010, -0.005, 0.015};
    enamel::Vec6 q;
    enamel::TauConfiguration solved = model.home;
    if (enamel::inverseKinematics(model, pose, q) != enamel::Status::ok) return 1;
    if (enamel::forwardKinematics(model, q, solved).status != enamel::Status::ok) return 1;
    const double error = (solved.pose.position - pose.position).norm();
    const double mass = enamel::massMatrix(model, solved).trace();
    std::printf("forward kinematics of the inverse: %.1e m off; trace of the mass matrix %.6f kg m^2\n", error, mass);
    const enamel::MeshModel jaw(enamel::loadMesh(ENAMEL_DATA_DIR "/meshes/jaw.ply", 1e-3));
    const enamel::SurfacePoint near = enamel::signedDistance(jaw, enamel::Vec3(0.0, 0.0225, 0.02));
    std::printf("20 mm above the gum: %.3f mm from the jaw\n", 1e3 * near.distance);
    if (!(near.distance > 0.0 && near.distance < 0.02)) return 1;
    return error < 1e-12 && mass > 0.0 ? 0 : 1;
  } catch (const enamel::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
