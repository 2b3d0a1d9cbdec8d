#include "study/study.hpp"

#include <fmt/core.h>

#include <map>

#include "enamel/core/file.hpp"
#include "study/page.hpp"

namespace enamel::app {

std::string Study::runsPath(int part) const {
  return path(options.parts == 1 ? "runs.csv" : fmt::format("runs-{}-of-{}.csv", part, options.parts));
}

std::size_t Study::column(ColumnKind kind) const {
  std::size_t i = 0;
  while (i < labels.size() && labels[i].kind != kind) ++i;
  return i;
}

std::string pointText(const Study& study, std::size_t point) {
  const Vec3 p = 1e3 * queryPoint(study.plan, point);
  return fmt::format("({:.4g}, {:.4g})", p.x(), p.y());
}

std::string checksumOf(const std::string& text) { return fmt::format("{:08x}", crc32(text)); }

std::string plantTitle(const std::string& plant) {
  static const std::map<std::string, std::string> titles = {{kClosedForm, "the ideal device"},
                                                            {kMultibody, "the device in Simbody"},
                                                            {kImperfect, "the imperfect plant"},
                                                            {kImperfectStiff, "the imperfect plant with stiff cables"}};
  const auto found = titles.find(plant);
  return found != titles.end() ? found->second : "the unit " + escape(plant);
}

std::string delayText(const std::string& delay) {
  const Delay d = parseDelay(delay);
  return d.high == 0      ? "no delay"
         : d.low < d.high ? fmt::format("{}..{} ticks", d.low, d.high)
         : d.high == 1    ? "1 tick"
                          : fmt::format("{} ticks", d.high);
}

std::string withoutFirstText(const WallSummary& wall) {
  std::string text;
  for (const FirstImpactVerdict verdict : kWithoutFirst)
    if (const int count = wall.verdicts[static_cast<std::size_t>(verdict)]; count > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, toString(verdict));
  return text;
}

std::string lostText(const WallSummary& wall) {
  std::string text;
  if (wall.failed > wall.stopped) text = fmt::format("{} runs left the workspace", wall.failed - wall.stopped);
  if (wall.stopped > 0)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", wall.stopped, toString(Status::stopped));
  return text;
}

bool anyFinished(const Study& study, const WallSummary& wall) {
  return static_cast<std::size_t>(wall.failed) < study.plan.points() * static_cast<std::size_t>(study.plan.runs);
}

}  // namespace enamel::app
