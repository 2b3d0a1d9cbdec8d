#include "canvas.hpp"

#include <GL/glew.h>  // before any other header that includes OpenGL
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <vtkGenericOpenGLRenderWindow.h>

#include <cstdio>
#include <cstring>

#include "enamel/core/error.hpp"
#include "offscreen/render_window.hpp"
#include "overlay.hpp"

namespace enamel::viewer {
Canvas::Canvas(Surface& surface, const std::string& font, const std::string& boldFont)
    : surface_(surface), font_(font), boldFont_(boldFont) {
  window_ = offscreen::makeRenderWindow(surface_, "enamel-viewer");
  const auto* drawnBy = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  for (const char* software : {"llvmpipe", "softpipe", "swrast"})
    software_ = software_ || (drawnBy != nullptr && std::strstr(drawnBy, software) != nullptr);
  window_->SetNumberOfLayers(2);
  for (vtkRenderer* above : {above_.Get(), aboveRight_.Get()}) above->SetLayer(1);
  for (vtkRenderer* one : {scene_.Get(), above_.Get(), right_.Get(), aboveRight_.Get(), charts_.Get()})
    window_->AddRenderer(one);

  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui::GetIO().LogFilename = nullptr;
  if (!ImGui_ImplOpenGL3_Init("#version 150")) throw Error("Dear ImGui cannot draw with this OpenGL context");
}

Canvas::~Canvas() {
  surface_.makeCurrent();
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
  window_->Finalize();
  window_->RemoveAllObservers();
}

void Canvas::draw(const Layout& layout, const std::function<void()>& overlay, bool picture) {
  surface_.makeCurrent();
  // Antialias both layers; this one is drawn last. In software this costs a third of the frame rate.
  for (vtkRenderer* above : {above_.Get(), aboveRight_.Get()}) above->SetUseFXAA(picture || !software_);
  if (layout.scale != fontScale_) {
    fontScale_ = layout.scale;
    setUpOverlay(font_, boldFont_, layout.scale);
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
    window_->SetDPI(static_cast<int>(72.0f * layout.scale));
  }
  const double w = layout.size.x, h = layout.size.y;
  const auto place = [w, h](vtkRenderer* renderer, const Rect& area) {
    renderer->SetDraw(area.width > 0 && area.height > 0);
    renderer->SetViewport(area.x / w, 1.0 - (area.y + area.height) / h, (area.x + area.width) / w, 1.0 - area.y / h);
  };
  place(scene_, layout.scene);
  place(above_, layout.scene);
  place(right_, layout.right);
  place(aboveRight_, layout.right);
  place(charts_, layout.charts);
  // Charts over seconds do not need every frame: VTK's framebuffer keeps what it does not draw again.
  const bool same = layout.size == chartsDrawn_.size && layout.charts.width == chartsDrawn_.charts.width;
  if (software_ && !picture && same && ++chartsAge_ < kChartsEvery)
    charts_->SetDraw(false);
  else
    chartsAge_ = 0;
  chartsDrawn_ = layout;
  glBindFramebuffer(GL_FRAMEBUFFER, surface_.framebuffer());
  if (window_->GetSize()[0] != layout.size.x || window_->GetSize()[1] != layout.size.y)
    window_->SetSize(layout.size.x, layout.size.y);
  window_->Render();

  glBindFramebuffer(GL_FRAMEBUFFER, surface_.framebuffer());
  glViewport(0, 0, layout.size.x, layout.size.y);
  glDisable(GL_SCISSOR_TEST);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::GetIO().DisplaySize = {static_cast<float>(layout.size.x), static_cast<float>(layout.size.y)};
  ImGui::NewFrame();
  overlay();
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  for (GLenum error = glGetError(); error != GL_NO_ERROR; error = glGetError()) {
    if (errors_++ == 0) std::fprintf(stderr, "enamel-viewer: OpenGL error 0x%04x\n", error);
    if (errors_ > 1000) break;
  }
}

Picture Canvas::read() {
  Picture picture;
  picture.size = surface_.size();
  picture.rgb.resize(3 * static_cast<std::size_t>(picture.size.x) * static_cast<std::size_t>(picture.size.y));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, surface_.framebuffer());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, picture.size.x, picture.size.y, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
  return picture;
}

}  // namespace enamel::viewer
