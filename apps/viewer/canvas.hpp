// One OpenGL context for everything: VTK's scene and charts, and Dear ImGui over them.
#pragma once

#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "layout.hpp"
#include "surface.hpp"

class vtkGenericOpenGLRenderWindow;

namespace enamel::viewer {

/// Pixels of a picture, three bytes each, the bottom row first, as OpenGL has them.
struct Picture {
  glm::ivec2 size{0};
  std::vector<unsigned char> rgb;
};

class Canvas {
 public:
  /// Throws Error: VTK cannot draw in the surface's context.
  Canvas(Surface& surface, const std::string& font, const std::string& boldFont);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  vtkRenderer* scene() { return scene_; }
  vtkRenderer* above() { return above_; }  ///< a layer over the scene
  vtkRenderer* right() { return right_; }  ///< the scene of the split screen's right pane, and the layer over it
  vtkRenderer* aboveRight() { return aboveRight_; }
  vtkRenderer* charts() { return charts_; }

  /// Draws VTK's part, then what `overlay` gives to ImGui, into the surface; does not present. A `picture` has smooth
  /// edges also where OpenGL draws in software.
  void draw(const Layout& layout, const std::function<void()>& overlay, bool picture);

  Picture read();

  /// OpenGL errors so far.
  std::uint64_t errors() const { return errors_; }

 private:
  Surface& surface_;
  std::string font_, boldFont_;
  float fontScale_ = 0.0f;
  bool software_ = false;
  static constexpr int kChartsEvery = 3;  // pictures, in software
  Layout chartsDrawn_;
  int chartsAge_ = 0;  // pictures since they were drawn
  vtkSmartPointer<vtkGenericOpenGLRenderWindow> window_;
  vtkNew<vtkRenderer> scene_, above_, right_, aboveRight_, charts_;
  std::uint64_t errors_ = 0;
};

}  // namespace enamel::viewer
