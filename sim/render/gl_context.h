#pragma once

#include <memory>
#include <string>

#include "vantage/math/error.h"

/// @file
/// Off-screen OpenGL contexts. No GL header here: functions are loaded through GetProc() into the
/// table of gl_functions.h, never linked. A process whose libraries bring in libGL (ViSP's do) would
/// otherwise call that library's stubs, which do nothing without a window system's context.

namespace vantage::sim {

/// The graphics library refused something, or is not what it claims.
class RenderError : public Error {
 public:
  using Error::Error;
};

/// One OpenGL 3.3 core context without a window. Used by one thread at a time.
class GlContext {
 public:
  using Proc = void (*)();

  GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  virtual ~GlContext() = default;

  /// Makes this the calling thread's context; nearly free when it already is. Throws RenderError.
  void MakeCurrent();

  /// Address of a GL function, or nullptr.
  [[nodiscard]] virtual Proc GetProc(const char* name) const = 0;

  /// Name of the backend, as the configuration spells it.
  [[nodiscard]] virtual std::string name() const = 0;

 protected:
  /// To be called by the destructor of each backend, while its context still exists.
  void ReleaseIfCurrent() noexcept;

 private:
  virtual void Bind() = 0;
  virtual void Unbind() noexcept = 0;
};

enum class GlBackend {
  kAuto,    ///< OSMesa; EGL where OSMesa is not installed.
  kOsmesa,  ///< Mesa's software renderer in this process (libOSMesa).
  kEgl,     ///< EGL without a surface: a GPU where there is one, else Mesa's software renderer.
};

/// A new context. Throws ConfigError (key "sim.renderer") when the backend's library (of kAuto: either) is
/// not installed, RenderError when it cannot make the context.
///
/// Sets LP_NUM_THREADS=0 in the environment unless it is set: Mesa's rasteriser threads cost more
/// than they bring at these image sizes. So the first call must come before other threads read the
/// environment.
[[nodiscard]] std::unique_ptr<GlContext> MakeGlContext(GlBackend backend = GlBackend::kAuto);

}  // namespace vantage::sim
