#pragma once

#include <GL/glcorearb.h>

#include "sim/render/gl_context.h"

/// @file
/// The GL functions that the renderer uses, one table a context.

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): the list makes members and loads them by name.
#define VANTAGE_GL_FUNCTIONS(F)                       \
  F(ATTACHSHADER, AttachShader)                       \
  F(BINDBUFFER, BindBuffer)                           \
  F(BINDFRAMEBUFFER, BindFramebuffer)                 \
  F(BINDRENDERBUFFER, BindRenderbuffer)               \
  F(BINDTEXTURE, BindTexture)                         \
  F(BINDVERTEXARRAY, BindVertexArray)                 \
  F(ACTIVETEXTURE, ActiveTexture)                     \
  F(BLENDFUNC, BlendFunc)                             \
  F(BUFFERDATA, BufferData)                           \
  F(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus)   \
  F(CLEAR, Clear)                                     \
  F(CLEARBUFFERUIV, ClearBufferuiv)                   \
  F(CLEARCOLOR, ClearColor)                           \
  F(COMPILESHADER, CompileShader)                     \
  F(CREATEPROGRAM, CreateProgram)                     \
  F(CREATESHADER, CreateShader)                       \
  F(DELETESHADER, DeleteShader)                       \
  F(DEPTHFUNC, DepthFunc)                             \
  F(DEPTHMASK, DepthMask)                             \
  F(DISABLE, Disable)                                 \
  F(DRAWARRAYS, DrawArrays)                           \
  F(DRAWELEMENTS, DrawElements)                       \
  F(ENABLE, Enable)                                   \
  F(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray) \
  F(FRAMEBUFFERRENDERBUFFER, FramebufferRenderbuffer) \
  F(FRONTFACE, FrontFace)                             \
  F(GENBUFFERS, GenBuffers)                           \
  F(GENFRAMEBUFFERS, GenFramebuffers)                 \
  F(GENRENDERBUFFERS, GenRenderbuffers)               \
  F(GENTEXTURES, GenTextures)                         \
  F(GENVERTEXARRAYS, GenVertexArrays)                 \
  F(GETERROR, GetError)                               \
  F(GETPROGRAMINFOLOG, GetProgramInfoLog)             \
  F(GETPROGRAMIV, GetProgramiv)                       \
  F(GETSHADERINFOLOG, GetShaderInfoLog)               \
  F(GETSHADERIV, GetShaderiv)                         \
  F(GETUNIFORMLOCATION, GetUniformLocation)           \
  F(LINKPROGRAM, LinkProgram)                         \
  F(MAPBUFFERRANGE, MapBufferRange)                   \
  F(PIXELSTOREI, PixelStorei)                         \
  F(READPIXELS, ReadPixels)                           \
  F(RENDERBUFFERSTORAGE, RenderbufferStorage)         \
  F(SCISSOR, Scissor)                                 \
  F(SHADERSOURCE, ShaderSource)                       \
  F(STENCILFUNC, StencilFunc)                         \
  F(STENCILOP, StencilOp)                             \
  F(TEXIMAGE2D, TexImage2D)                           \
  F(TEXPARAMETERI, TexParameteri)                     \
  F(UNIFORM1F, Uniform1f)                             \
  F(UNIFORM1I, Uniform1i)                             \
  F(UNIFORM1UI, Uniform1ui)                           \
  F(UNIFORM2FV, Uniform2fv)                           \
  F(UNIFORM3FV, Uniform3fv)                           \
  F(UNIFORM4FV, Uniform4fv)                           \
  F(UNIFORMMATRIX3FV, UniformMatrix3fv)               \
  F(UNIFORMMATRIX4FV, UniformMatrix4fv)               \
  F(UNMAPBUFFER, UnmapBuffer)                         \
  F(USEPROGRAM, UseProgram)                           \
  F(VERTEXATTRIBPOINTER, VertexAttribPointer)         \
  F(VIEWPORT, Viewport)

namespace vantage::sim {

struct GlFunctions {
#define VANTAGE_GL_MEMBER(upper, name) PFNGL##upper##PROC name{nullptr};
  VANTAGE_GL_FUNCTIONS(VANTAGE_GL_MEMBER)
#undef VANTAGE_GL_MEMBER
};

/// Loads every function. Throws RenderError that names the first one missing.
[[nodiscard]] GlFunctions LoadGlFunctions(const GlContext& context);

}  // namespace vantage::sim
