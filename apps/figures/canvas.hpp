// One figure on its way to a PNG: drawn at twice its size and averaged, because software OpenGL smooths nothing.
#pragma once

#include <vtkContextScene.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "offscreen/surface.hpp"

class vtkGenericOpenGLRenderWindow;
class vtkTextProperty;

namespace enamel::figures {

using Json = nlohmann::json;

/// Everything in the description is in pixels of the finished figure from its top left; drawing is in kOversampling
/// times as many from the bottom left.
inline constexpr int kOversampling = 2;

class Canvas {
 public:
  /// Throws Error: no OpenGL without a display.
  explicit Canvas(const glm::ivec2& size);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  vtkRenderer* solids() { return solids_; }         ///< below
  vtkContextScene* charts() { return charts_; }     ///< above
  const glm::ivec2& size() const { return size_; }  ///< of the finished figure

  /// Draws and writes the PNG. Throws Error: the file cannot be written.
  void write(const std::string& path);

 private:
  glm::ivec2 size_;
  std::unique_ptr<offscreen::Surface> surface_;
  vtkSmartPointer<vtkGenericOpenGLRenderWindow> window_;
  vtkNew<vtkRenderer> solids_, above_;
  vtkSmartPointer<vtkContextScene> charts_;
};

/// Sets font, size (of the finished figure, pixels) and colour.
void setText(vtkTextProperty* text, double size, const std::string& colour);

/// "#RRGGBB" as three bytes. Throws Error: anything else.
glm::u8vec3 colourOf(const std::string& text);

}  // namespace enamel::figures
