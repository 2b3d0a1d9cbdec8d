// Debian's GLEW knows GLX only: in an EGL context glewInit() loads every function, then reports that there is no GLX
// display, and VTK would log an error per frame. This definition stands before the library's and takes that report
// for what it is.
#include <GL/glew.h>
#include <dlfcn.h>

extern "C" GLenum glewInit() {
  using Function = GLenum (*)();
  static const auto original = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "glewInit"));  // NOLINT: what dlsym returns
  if (original == nullptr) return GLEW_ERROR_NO_GL_VERSION;
  const GLenum result = original();
  return result == GLEW_ERROR_NO_GLX_DISPLAY ? GLEW_OK : result;
}
