// One self-contained page that plays recordings in a browser: enamel replay --html.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel::app {

/// The numbers of a page: arrays one after the other, addressed by their first byte.
class PageNumbers {
 public:
  /// Return {"at": byte, "count": numbers, "type": f32, u32, u16, i8 or u8}.
  template <typename T>
  nlohmann::json add(const std::vector<T>& values);
  const std::string& bytes() const noexcept { return bytes_; }

 private:
  std::string bytes_;
};

/// The data that a page shows of one replay. It has the motion at 60 Hz, the extremes of force and depth over all
/// ticks, and the solids at 10 Hz while a bur cuts them.
class PageSide {
 public:
  /// `title` distinguishes the side from the other one. The solids must be as before the first tick; the drill (null:
  /// no drill) cuts those of `scene`. `isAsked`: this renderer was only asked for its torque, the motors received the
  /// recorded renderer's. Such a side is shown with the first side's motion and solids.
  PageSide(std::string title, const RecordingHeader& header, const SceneFile& scene, const Drill* drill, bool isAsked);

  /// Add a tick after it has run.
  void see(const RecordedTick& recorded, const HapticTick& tick);

  /// Return the data for the page's script. Throws Error: no tick was added.
  nlohmann::json finish(PageNumbers& numbers);

 private:
  struct Brick {
    float time;  // s; the brick has these samples from this time on
    int number;
    BrickSamples samples;
  };
  struct Copy {  // of the solid of an obstacle
    std::shared_ptr<Solid> solid;
    std::vector<BrickSamples> uncut;
    std::vector<Brick> changes;
  };
  // Smallest and largest value of each bucket of ticks.
  struct Curve {
    std::vector<float> low, high;
    void add(double value, bool isNew);
  };

  void takeBricks(float time);
  void halveCurves();
  void halvePictures();
  nlohmann::json meshOf(const std::vector<Vec3>& vertices, const std::vector<Vec3>& normals,
                        const std::vector<Vec3>& colours, const std::vector<std::array<int, 3>>& triangles,
                        PageNumbers& numbers) const;
  nlohmann::json solidOf(const Copy& copy, PageNumbers& numbers) const;
  nlohmann::json obstacleOf(std::size_t number, PageNumbers& numbers) const;

  std::string title_;
  const RecordingHeader& header_;
  const SceneFile& scene_;
  const Drill* drill_;
  bool isAsked_;
  std::vector<Copy> copies_;  // one for each obstacle
  double begin_ = 0.0, end_ = 0.0, bricksAt_ = 0.0;
  std::uint64_t ticks_ = 0, everyPicture_, everyCurve_ = 1;  // ticks
  std::vector<float> times_, poses_, forces_, depths_, contacts_, removed_;
  std::vector<std::uint8_t> guards_;
  RemovedVolume sum_{};
  Curve force_, depth_;
};

/// Write the page with one or two sides. Throws Error: this build has no page, because it needs three.js and zlib (the
/// message names the packages); the file cannot be written.
void writeReplayPage(const std::string& path, const std::vector<nlohmann::json>& sides, const PageNumbers& numbers);

/// Throw the Error of a build without a page before any work is done.
void checkReplayPage();

}  // namespace enamel::app
