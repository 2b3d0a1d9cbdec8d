#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glew.h>

#include "enamel/core/error.hpp"
#include "surface.hpp"

namespace enamel::offscreen {
namespace {

class Headless final : public Surface {
 public:
  Headless(const glm::ivec2& size, float scale) : scale_(scale) {
    const auto getDisplay = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(  // NOLINT: required by EGL
        eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (getDisplay == nullptr) throw Error("no OpenGL without a display: EGL does not support platform displays");
    display_ = getDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) != EGL_TRUE)
      throw Error("no OpenGL without a display: EGL does not support the surfaceless platform");
    const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
    const EGLint version[] = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 2, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE && eglChooseConfig(display_, wanted, &config, 1, &count) == EGL_TRUE &&
        count > 0)
      context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version);
    if (context_ == EGL_NO_CONTEXT || eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
      eglTerminate(display_);
      throw Error("no OpenGL without a display: EGL does not provide an OpenGL 3.2 core context");
    }
    glewExperimental = GL_TRUE;
    glewInit();
    allocate(size);
  }

  ~Headless() override {
    release();
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }

  void makeCurrent() override { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_); }
  bool isCurrent() const override { return eglGetCurrentContext() == context_; }
  glm::ivec2 size() const override { return size_; }
  float scale() const override { return scale_; }
  unsigned framebuffer() const override { return framebuffer_; }
  void present() override { glFlush(); }

  void resize(const glm::ivec2& size) override {
    if (size == size_) return;
    release();
    allocate(size);
  }

 private:
  void allocate(const glm::ivec2& size) {
    size_ = size;
    glGenFramebuffers(1, &framebuffer_);
    glGenRenderbuffers(2, buffers_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers_[0]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, size.x, size.y);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers_[0]);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers_[1]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, size.x, size.y);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, buffers_[1]);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      throw Error("OpenGL does not provide a framebuffer of " + std::to_string(size.x) + " x " +
                  std::to_string(size.y));
  }

  void release() {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteRenderbuffers(2, buffers_);
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  glm::ivec2 size_{0};
  float scale_;
  unsigned framebuffer_ = 0, buffers_[2] = {0, 0};
};

}  // namespace

std::unique_ptr<Surface> openHeadless(const glm::ivec2& size, float scale) {
  return std::make_unique<Headless>(size, scale);
}

}  // namespace enamel::offscreen
