// VTK's window in an existing OpenGL context.
#pragma once

#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkSmartPointer.h>

#include "surface.hpp"

namespace enamel::offscreen {

/// Make a window that draws into `surface`, which must outlive it. VTK's messages go to stderr, one line each, after
/// the name of the program. Call Finalize() and RemoveAllObservers() before the surface ends.
vtkSmartPointer<vtkGenericOpenGLRenderWindow> makeRenderWindow(Surface& surface, const char* program);

}  // namespace enamel::offscreen
