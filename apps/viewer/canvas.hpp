// The OpenGL context of everything: VTK's scene and charts, with Dear ImGui over them.
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

/// Pixels of a picture with three bytes each; the bottom row comes first, as in OpenGL.
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
  vtkRenderer* above() { return above_; }  ///< layer over the scene
  vtkRenderer* right() { return right_; }  ///< scene of the split screen's right pane, and the layer over it
  vtkRenderer* aboveRight() { return aboveRight_; }
  vtkRenderer* charts() { return charts_; }

  /// Draw VTK's part and then the overlay into the surface, without presenting it. A `picture` is antialiased even if
  /// OpenGL runs in software.
  void draw(const Layout& layout, const std::function<void()>& overlay, bool picture);

  Picture read();

  /// Return the number of OpenGL errors so far.
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
