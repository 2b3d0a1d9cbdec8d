#include "render_window.hpp"

#include <GL/glew.h>  // before any other header that includes OpenGL
#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>

#include <cstdio>
#include <string>

namespace enamel::offscreen {
namespace {

// Prints VTK's messages as one line each on stderr instead of a page.
class Messages final : public vtkOutputWindow {
 public:
  static Messages* New();
  vtkTypeMacro(Messages, vtkOutputWindow) void DisplayText(const char* text) override {
    std::string line(text);
    for (char& c : line)
      if (c == '\n') c = ' ';
    std::fprintf(stderr, "%s: VTK: %s\n", program, line.c_str());
  }
  const char* program = "";
};
vtkStandardNewMacro(Messages)

    void observe(vtkObject* subject, unsigned long event, void* client,
                 void (*callback)(vtkObject*, unsigned long, void*, void*)) {
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(client);
  command->SetCallback(callback);
  subject->AddObserver(event, command);
}

}  // namespace

vtkSmartPointer<vtkGenericOpenGLRenderWindow> makeRenderWindow(Surface& surface, const char* program) {
  vtkNew<Messages> messages;
  messages->program = program;
  vtkOutputWindow::SetInstance(messages);
  surface.makeCurrent();
  auto window = vtkSmartPointer<vtkGenericOpenGLRenderWindow>::New();
  window->SetReadyForRendering(false);
  window->SetOwnContext(0);
  window->SetMultiSamples(0);
  observe(window, vtkCommand::WindowMakeCurrentEvent, &surface,
          [](vtkObject*, unsigned long, void* client, void*) { static_cast<Surface*>(client)->makeCurrent(); });
  observe(window, vtkCommand::WindowIsCurrentEvent, &surface,
          [](vtkObject*, unsigned long, void* client, void* answer) {
            *static_cast<bool*>(answer) = static_cast<Surface*>(client)->isCurrent();
          });
  observe(window, vtkCommand::WindowSupportsOpenGLEvent, &surface,
          [](vtkObject*, unsigned long, void*, void* answer) { *static_cast<int*>(answer) = 1; });
  window->SetFrameBlitModeToBlitToCurrent();
  const glm::ivec2 size = surface.size();
  window->SetSize(size.x, size.y);
  window->SetMapped(1);
  window->OpenGLInitContext();
  window->SetReadyForRendering(true);
  window->OpenGLInit();
  return window;
}

}  // namespace enamel::offscreen
