#include "sim/render/gl_functions.h"

#include <string>

namespace vantage::sim {
namespace {

template <typename Function>
Function Load(const GlContext& context, const char* name) {
  const GlContext::Proc address = context.GetProc(name);
  if (address == nullptr) throw RenderError(context.name() + " has no " + name);
  return reinterpret_cast<Function>(address);
}

}  // namespace

GlFunctions LoadGlFunctions(const GlContext& context) {
  GlFunctions gl;
#define VANTAGE_GL_LOAD(upper, name) gl.name = Load<PFNGL##upper##PROC>(context, "gl" #name);
  VANTAGE_GL_FUNCTIONS(VANTAGE_GL_LOAD)
#undef VANTAGE_GL_LOAD
  return gl;
}

}  // namespace vantage::sim
