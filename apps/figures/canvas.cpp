#include "canvas.hpp"

#include <GL/glew.h>  // before anything that includes OpenGL
#include <vtkContextActor.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkTextProperty.h>

#include <vector>

#include "enamel/core/error.hpp"
#include "offscreen/png.hpp"
#include "offscreen/render_window.hpp"

namespace enamel::figures {

Canvas::Canvas(const glm::ivec2& size) : size_(size), surface_(offscreen::openHeadless(kOversampling * size, 1.0f)) {
  window_ = offscreen::makeRenderWindow(*surface_, "enamel-figures");
  window_->SetDPI(72);  // a point is a pixel
  window_->SetNumberOfLayers(2);
  solids_->SetBackground(1.0, 1.0, 1.0);
  above_->SetLayer(1);
  window_->AddRenderer(solids_);
  window_->AddRenderer(above_);
  vtkNew<vtkContextActor> actor;
  charts_ = actor->GetScene();
  charts_->SetRenderer(above_);
  above_->AddActor(actor);
}

Canvas::~Canvas() {
  surface_->makeCurrent();
  window_->Finalize();
  window_->RemoveAllObservers();
}

void Canvas::write(const std::string& path) {
  surface_->makeCurrent();
  glBindFramebuffer(GL_FRAMEBUFFER, surface_->framebuffer());
  window_->Render();
  const auto width = static_cast<std::size_t>(size_.x), height = static_cast<std::size_t>(size_.y);
  constexpr std::size_t n = kOversampling;
  std::vector<unsigned char> drawn(3 * n * n * width * height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, surface_->framebuffer());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, kOversampling * size_.x, kOversampling * size_.y, GL_RGB, GL_UNSIGNED_BYTE, drawn.data());

  std::vector<unsigned char> pixels(3 * width * height);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        unsigned sum = n * n / 2;
        for (std::size_t j = 0; j < n; ++j)
          for (std::size_t i = 0; i < n; ++i) sum += drawn[3 * ((n * y + j) * n * width + n * x + i) + c];
        pixels[3 * (y * width + x) + c] = static_cast<unsigned char>(sum / (n * n));
      }
  offscreen::writePng(size_.x, size_.y, pixels.data(), path);
}

void setText(vtkTextProperty* text, double size, const std::string& colour) {
  const glm::u8vec3 c = colourOf(colour);
  text->SetFontSize(static_cast<int>(kOversampling * size));
  text->SetColor(c.r / 255.0, c.g / 255.0, c.b / 255.0);
  text->BoldOff();
  text->ItalicOff();
  text->ShadowOff();
  if (ENAMEL_FIGURE_FONT[0] == '/') {
    text->SetFontFamily(VTK_FONT_FILE);
    text->SetFontFile(ENAMEL_FIGURE_FONT);
  }
}

glm::u8vec3 colourOf(const std::string& text) {
  unsigned rgb = 0;
  char rest = 0;
  if (text.size() != 7 || std::sscanf(text.c_str(), "#%6x%c", &rgb, &rest) != 1)
    throw Error("\"" + text + "\" is not a colour like #0072B2");
  return {rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255};
}

}  // namespace enamel::figures
