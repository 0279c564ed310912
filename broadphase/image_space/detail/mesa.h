// SPDX-License-Identifier: MIT
#pragma once

#define GL_GLEXT_PROTOTYPES 1
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>

namespace selvedge::detail {

#define SELVEDGE_MESA_FUNCTIONS(X) \
  X(glAttachShader)                \
  X(glBindBuffer)                  \
  X(glBindFramebuffer)             \
  X(glBindRenderbuffer)            \
  X(glBindVertexArray)             \
  X(glBufferData)                  \
  X(glCheckFramebufferStatus)      \
  X(glClearBufferfv)               \
  X(glClearBufferiv)               \
  X(glCompileShader)               \
  X(glCreateProgram)               \
  X(glCreateShader)                \
  X(glDeleteShader)                \
  X(glDepthFunc)                   \
  X(glDrawBuffers)                 \
  X(glDrawElements)                \
  X(glEnable)                      \
  X(glEnableVertexAttribArray)     \
  X(glFramebufferRenderbuffer)     \
  X(glGenBuffers)                  \
  X(glGenFramebuffers)             \
  X(glGenRenderbuffers)            \
  X(glGenVertexArrays)             \
  X(glGetError)                    \
  X(glGetProgramiv)                \
  X(glGetShaderiv)                 \
  X(glGetString)                   \
  X(glLinkProgram)                 \
  X(glReadBuffer)                  \
  X(glReadPixels)                  \
  X(glRenderbufferStorage)         \
  X(glShaderSource)                \
  X(glUseProgram)                  \
  X(glVertexAttribPointer)         \
  X(glViewport)                    \
  X(OSMesaCreateContextAttribs)    \
  X(OSMesaDestroyContext)          \
  X(OSMesaMakeCurrent)

/// The functions of OSMesa and OpenGL that draw off screen. The library is loaded when a picture is
/// first drawn: with LLVM, which it needs, it would take every program that links it 50 ms and 40
/// MB at the start.
struct Mesa {
#define SELVEDGE_DECLARE(name) decltype(&::name) name;
  SELVEDGE_MESA_FUNCTIONS(SELVEDGE_DECLARE)
#undef SELVEDGE_DECLARE
};

/// Throws std::runtime_error if the library cannot be loaded.
const Mesa& mesa();

}  // namespace selvedge::detail
