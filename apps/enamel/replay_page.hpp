// One page that plays recordings in a browser, with all that it needs inside: enamel replay --html.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel::app {

/// The numbers of a page: arrays behind each other, named by where they begin.
class PageNumbers {
 public:
  /// Returns {"at": byte, "count": numbers, "type": f32, u32, u16, i8 or u8}.
  template <typename T>
  nlohmann::json add(const std::vector<T>& values);
  const std::string& bytes() const noexcept { return bytes_; }

 private:
  std::string bytes_;
};

/// What a page shows of one replay: the motion 60 times a second, forces and depths of every tick as their extremes,
/// and what a bur has left of the solids, ten times a second.
class PageSide {
 public:
  /// `title` tells the side from another one. The solids are as before the first tick; the drill, null where there is
  /// none, cuts those of `scene`. `isAsked`: the motors never got what the renderer answered, only the recorded one's;
  /// it is shown beside the first side's motion, and has none.
  PageSide(std::string title, const RecordingHeader& header, const SceneFile& scene, const Drill* drill, bool isAsked);

  /// Every tick after it was run.
  void see(const RecordedTick& recorded, const HapticTick& tick);

  /// As the page's script takes it. Throws Error: no tick was seen.
  nlohmann::json finish(PageNumbers& numbers);

 private:
  struct Brick {
    float time;  // from when on it is so, s
    int number;
    BrickSamples samples;
  };
  struct Copy {  // of an obstacle's solid
    std::shared_ptr<Solid> solid;
    std::vector<BrickSamples> uncut;
    std::vector<Brick> changes;
  };
  // Smallest and largest value of several ticks.
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
  std::vector<Copy> copies_;  // by obstacle
  double begin_ = 0.0, end_ = 0.0, bricksAt_ = 0.0;
  std::uint64_t ticks_ = 0, everyPicture_, everyCurve_ = 1;  // ticks
  std::vector<float> times_, poses_, forces_, depths_, contacts_, removed_;
  std::vector<std::uint8_t> guards_;
  RemovedVolume sum_{};
  Curve force_, depth_;
};

/// Writes the page with one or two sides. Throws Error: this build has no such page (it needs three.js and zlib, and
/// says which packages); the file cannot be written.
void writeReplayPage(const std::string& path, const std::vector<nlohmann::json>& sides, const PageNumbers& numbers);

/// Throws Error where writeReplayPage() could not but throw: before the work.
void checkReplayPage();

}  // namespace enamel::app
