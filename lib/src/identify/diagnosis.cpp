#include "identify/diagnosis.hpp"

#include <algorithm>
#include <cstdio>

namespace enamel::identify {
namespace {

constexpr double kEvidence = 30.0;                       // gain of the log likelihood
constexpr double kLeastLoss = 0.3;                       // of the torque above the limit
constexpr double kLevels[] = {0.4, 0.5, 0.6, 0.7, 0.8};  // of the largest command

// How much of the command above a level is missing.
struct Loss {
  double level = 0.0, share = 0.0, evidence = 0.0;
};

Loss lossAbove(const Fit& fit, Eigen::Index joint, const Eigen::VectorXd& residual, const Eigen::VectorXd& command,
               double level) {
  const Eigen::VectorXd above = command - command.cwiseMin(level).cwiseMax(-level);
  const Eigen::VectorXd term = fit.whitenTorque(joint, above);
  const double square = term.squaredNorm(), product = term.dot(residual);
  if (!(square > 0.0)) return {};
  return {level, -product / square, 0.5 * product * product / square};
}

}  // namespace

std::vector<std::string> diagnose(Fit& fit, int delay) {
  std::vector<std::string> problems;
  const std::vector<Eigen::VectorXd> residuals = fit.whiteTorque();
  const Eigen::MatrixXd commands = fit.residualCommand(delay);
  for (Eigen::Index joint = 0; joint < commands.rows(); ++joint) {
    const Eigen::VectorXd command = commands.row(joint);
    const double largest = command.cwiseAbs().maxCoeff();
    Loss worst;
    for (const double level : kLevels) {
      const Loss loss = lossAbove(fit, joint, residuals[static_cast<std::size_t>(joint)], command, level * largest);
      if (loss.share > kLeastLoss && loss.evidence > std::max(kEvidence, worst.evidence)) worst = loss;
    }
    if (worst.evidence == 0.0) continue;
    char text[200];
    std::snprintf(text, sizeof(text),
                  "the motor of %s saturates: above about %.3g N m or N it lacks %.0f %% of the command",
                  jointName(fit.model().device, static_cast<int>(joint)).c_str(), worst.level, 100.0 * worst.share);
    problems.push_back(text);
  }
  return problems;
}

}  // namespace enamel::identify
