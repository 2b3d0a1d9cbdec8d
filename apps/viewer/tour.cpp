#include "tour.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

namespace enamel::viewer {
namespace {

constexpr double kSlide = 0.010;  // m, to each side

// Position of the hand between start (0) and pressed (1), and along the wall (-1 to 1).
struct Keyframe {
  double time;  // s
  double pressed, along;
};
constexpr Keyframe kKeyframes[] = {
    {0.0, 0.0, 0.0},  {7.0, 0.0, 0.0},  {8.0, 1.0, 0.0},  {9.5, 1.0, 1.0},  {12.0, 1.0, -1.0},
    {13.5, 1.0, 0.0}, {15.0, 1.0, 0.0}, {15.1, 0.0, 0.0}, {17.0, 0.0, 0.0}, {18.0, 1.0, 0.0},
    {18.5, 1.0, 0.0}, {18.6, 0.0, 0.0}, {20.0, 0.0, 0.0},
};
constexpr double kEnds[] = {7.0, 14.0, Tour::kLength};  // ends of the parts, s
constexpr Tour::Words kWords[] = {
    {"Push", "Both tools get the same push of 12 N. The stiffer wall lets its tool sink less."},
    {"Slide", "One hand presses both tools and drags them along the wall."},
    {"Let go", "The hand lifts off at once: see how each wall responds."},
};
static_assert(std::size(kEnds) == Tour::kParts && std::size(kWords) == Tour::kParts);

}  // namespace

Tour::Tour(const Vec3& start, const Contact& nearest, const Grip& grip) noexcept : start_(start) {
  const Vec3& n = nearest.normal;
  const Vec3 stiffness = stiffnessOf(grip);
  // Target with which the springs give the force along the normal when the tool touches the wall.
  pressed_ = start - nearest.gap * n - kForce * n.cwiseQuotient(stiffness);
  const Vec3 sideways = Vec3(1.0, 0.0, 0.0) - n.x() * n;
  along_ = kSlide * (sideways.norm() > 0.1 ? Vec3(sideways.normalized()) : Vec3(0.0, 1.0, 0.0));
}

Vec3 Tour::hand(double time) const noexcept {
  const Keyframe* next = std::find_if(std::begin(kKeyframes), std::end(kKeyframes) - 1,
                                      [time](const Keyframe& k) { return k.time >= time; });
  const Keyframe* before = next == kKeyframes ? next : next - 1;
  const double share = next == before ? 0.0 : std::clamp((time - before->time) / (next->time - before->time), 0.0, 1.0);
  const double pressed = before->pressed + share * (next->pressed - before->pressed);
  const double along = before->along + share * (next->along - before->along);
  return start_ + pressed * (pressed_ - start_) + along * along_;
}

std::size_t Tour::part(double time) noexcept {
  std::size_t part = 0;
  while (part + 1 < kParts && time >= kEnds[part]) ++part;
  return part;
}

const Tour::Words& Tour::words(std::size_t part) noexcept { return kWords[part]; }

void HandMotion::startTour(const Tour& tour, double now) {
  tour_ = tour;
  begin_ = now;
  pushed_ = false;
}

bool HandMotion::takePush(double now) {
  const bool due = tour_ && now - begin_ >= Tour::kPush;
  return due && !std::exchange(pushed_, true);
}

void HandMotion::startLine(const Vec3& from, const Vec3& to, double seconds, double now) {
  line_ = Line{from, to, seconds};
  begin_ = now;
}

std::optional<Vec3> HandMotion::target(double now) {
  if (tour_) return tour_->hand(now - begin_);
  if (!line_) return std::nullopt;
  const double share = line_->seconds > 0.0 ? std::min(1.0, (now - begin_) / line_->seconds) : 1.0;
  const Vec3 at = (line_->from * (1.0 - share) + line_->to * share) / 1e3;
  if (share >= 1.0) line_.reset();
  return at;
}

bool isFirstStart() {
  namespace fs = std::filesystem;
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  fs::path folder;
  if (state != nullptr && *state == '/')
    folder = state;
  else if (home != nullptr && *home == '/')
    folder = fs::path(home) / ".local" / "state";
  else
    return false;
  folder /= "enamel";
  const fs::path file = folder / "viewer-was-started";
  std::error_code error;
  if (fs::exists(file, error) || error) return false;
  fs::create_directories(folder, error);
  std::ofstream mark(file);
  mark << "The tour of enamel-viewer was shown. Delete this file to show it again.\n";
  return mark.flush().good();
}

}  // namespace enamel::viewer
