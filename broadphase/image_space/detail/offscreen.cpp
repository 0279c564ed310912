// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/image_space/detail/mesa.h>
#include <selvedge/broadphase/image_space/detail/offscreen.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// Floats per vertex in the buffer: position in the picture, normal, motion.
constexpr int kFloats = 9;

constexpr const char* kVertexShader = R"(#version 330 core
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 motion;
out vec4 normal_depth_of_vertex;
out vec3 motion_of_vertex;
void main() {
  gl_Position = vec4(place, 1.0);
  normal_depth_of_vertex = vec4(normal, place.z);
  motion_of_vertex = motion;
})";

constexpr const char* kFragmentShader = R"(#version 330 core
in vec4 normal_depth_of_vertex;
in vec3 motion_of_vertex;
layout(location = 0) out int triangle;
layout(location = 1) out vec4 normal_depth;
layout(location = 2) out vec4 motion;
void main() {
  triangle = gl_PrimitiveID;
  normal_depth = normal_depth_of_vertex;
  motion = vec4(motion_of_vertex, 0.0);
})";

constexpr const char* kIndexVertexShader = R"(#version 330 core
layout(location = 0) in vec3 place;
void main() { gl_Position = vec4(place, 1.0); })";

constexpr const char* kIndexFragmentShader = R"(#version 330 core
layout(location = 0) out int triangle;
void main() { triangle = gl_PrimitiveID; })";

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error("image space: " + what);
}

void check_errors(const char* when) {
  if (const GLenum error = mesa().glGetError(); error != GL_NO_ERROR)
    fail("OpenGL error " + std::to_string(error) + " while it " + when);
}

GLuint compiled(GLenum kind, const char* source) {
  const GLuint shader = mesa().glCreateShader(kind);
  mesa().glShaderSource(shader, 1, &source, nullptr);
  mesa().glCompileShader(shader);
  GLint good = 0;
  mesa().glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good != GL_TRUE) fail("OpenGL refuses a shader");
  return shader;
}

GLuint linked(const char* vertex_source, const char* fragment_source) {
  const GLuint vertex = compiled(GL_VERTEX_SHADER, vertex_source);
  const GLuint fragment = compiled(GL_FRAGMENT_SHADER, fragment_source);
  const GLuint program = mesa().glCreateProgram();
  mesa().glAttachShader(program, vertex);
  mesa().glAttachShader(program, fragment);
  mesa().glLinkProgram(program);
  mesa().glDeleteShader(vertex);
  mesa().glDeleteShader(fragment);
  GLint good = 0;
  mesa().glGetProgramiv(program, GL_LINK_STATUS, &good);
  if (good != GL_TRUE) fail("OpenGL refuses to link the shaders");
  return program;
}

/// A driver of this name ends the program at its first call, so it is rejected before.
void refuse_other_drivers() {
  const char* driver = std::getenv("GALLIUM_DRIVER");
  if (driver && *driver != '\0' && std::strcmp(driver, "llvmpipe") != 0)
    fail("GALLIUM_DRIVER is " + std::string(driver) + "; only llvmpipe is supported, unset it");
}

}  // namespace

int checked_resolution(int resolution, const std::string& who) {
  if (resolution < kLeastResolution || resolution > kMostResolution)
    throw std::invalid_argument(who + ": resolution is " + std::to_string(resolution) +
                                " texels; it must be " + std::to_string(kLeastResolution) + " to " +
                                std::to_string(kMostResolution));
  return resolution;
}

MapFrame frame_around(std::span<const Vec3> x, std::span<const Triangle> triangles,
                      const MapAxes& axes, int resolution, const std::string& name) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3 lo = Vec3::Constant(infinity), hi = Vec3::Constant(-infinity);
  Mat3 to_frame;
  to_frame << axes.right.transpose(), axes.up.transpose(), axes.toward.transpose();
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) {
      const Vec3 p = to_frame * x[v];
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
  MapFrame frame;
  frame.axes = axes;
  if (triangles.empty()) lo = hi = Vec3::Zero();
  frame.half = 0.5 * (hi - lo);
  frame.center = to_frame.transpose() * (0.5 * lo + 0.5 * hi);
  if (!frame.half.allFinite() || !frame.center.allFinite())
    throw std::invalid_argument(name + ": vertices lie too far apart for a picture");
  // One texel is left free on each side, so that points on the border are in the picture.
  const double side = 2.0 * std::max(frame.half[0], frame.half[1]);
  if (side > 0.0) frame.texel = side / (resolution - 2);
  const auto texels = [&](double half) {
    return std::min(resolution, static_cast<int>(std::ceil(2.0 * half / frame.texel)) + 2);
  };
  frame.width = texels(frame.half[0]);
  frame.height = texels(frame.half[1]);
  return frame;
}

struct OffscreenRenderer::Context {
  OSMesaContext handle = nullptr;
  std::uint32_t pixel = 0;  ///< required by OSMesa; nothing is drawn there
  GLuint program = 0, index_program = 0, vertex_array = 0, vertices = 0, elements = 0;
  GLuint framebuffer = 0, depth = 0;
  std::array<GLuint, 3> colours{};  ///< index, normal and depth, motion
  int width = 0, height = 0;
  bool coloured = false;
  std::vector<float> upload;

  /// Makes the context current on this thread for the lifetime of the object.
  class Current {
   public:
    explicit Current(Context& context) {
      if (mesa().OSMesaMakeCurrent(context.handle, &context.pixel, GL_UNSIGNED_BYTE, 1, 1) !=
          GL_TRUE)
        fail("OSMesa cannot make its context current on this thread");
    }
    ~Current() { mesa().OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0); }
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
  };

  Context() {
    refuse_other_drivers();
    const int wanted[] = {OSMESA_FORMAT,
                          OSMESA_RGBA,
                          OSMESA_PROFILE,
                          OSMESA_CORE_PROFILE,
                          OSMESA_CONTEXT_MAJOR_VERSION,
                          3,
                          OSMESA_CONTEXT_MINOR_VERSION,
                          3,
                          0};
    handle = mesa().OSMesaCreateContextAttribs(wanted, nullptr);
    if (!handle)
      fail("OSMesa cannot create an OpenGL 3.3 context; is its driver llvmpipe installed?");
    try {
      set_up();
    } catch (...) {  // the destructor of a partly constructed object does not run
      mesa().OSMesaDestroyContext(handle);
      throw;
    }
  }
  ~Context() {
    // Also frees all objects created in the context.
    mesa().OSMesaDestroyContext(handle);
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  void set_up() {
    const Current current(*this);
    const auto* renderer = reinterpret_cast<const char*>(mesa().glGetString(GL_RENDERER));
    if (!renderer || !std::strstr(renderer, "llvmpipe"))
      fail(std::string("OSMesa draws with ") + (renderer ? renderer : "an unknown renderer") +
           "; only llvmpipe is supported");
    program = linked(kVertexShader, kFragmentShader);
    index_program = linked(kIndexVertexShader, kIndexFragmentShader);
    mesa().glGenVertexArrays(1, &vertex_array);
    mesa().glBindVertexArray(vertex_array);
    mesa().glGenBuffers(1, &vertices);
    mesa().glGenBuffers(1, &elements);
    mesa().glBindBuffer(GL_ARRAY_BUFFER, vertices);
    mesa().glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, elements);
    mesa().glGenFramebuffers(1, &framebuffer);
    mesa().glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    mesa().glGenRenderbuffers(1, &depth);
    mesa().glGenRenderbuffers(3, colours.data());
    check_errors("starts");
  }

  /// Allocates pictures of this size and discards the previous ones.
  void resize(int new_width, int new_height, bool with_colours) {
    if (width == new_width && height == new_height && coloured == with_colours) return;
    width = height = 0;
    const auto attach = [&](GLuint buffer, GLenum format, GLenum place, bool wanted) {
      mesa().glBindRenderbuffer(GL_RENDERBUFFER, buffer);
      if (wanted) mesa().glRenderbufferStorage(GL_RENDERBUFFER, format, new_width, new_height);
      mesa().glFramebufferRenderbuffer(GL_FRAMEBUFFER, place, GL_RENDERBUFFER, wanted ? buffer : 0);
    };
    attach(depth, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT, true);
    attach(colours[0], GL_R32I, GL_COLOR_ATTACHMENT0, true);
    attach(colours[1], GL_RGBA32F, GL_COLOR_ATTACHMENT1, with_colours);
    attach(colours[2], GL_RGBA32F, GL_COLOR_ATTACHMENT2, with_colours);
    const GLenum targets[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    mesa().glDrawBuffers(with_colours ? 3 : 1, targets);
    if (const GLenum status = mesa().glCheckFramebufferStatus(GL_FRAMEBUFFER);
        status != GL_FRAMEBUFFER_COMPLETE)
      fail("OpenGL cannot create a picture of " + std::to_string(new_width) + " x " +
           std::to_string(new_height) + " texels (framebuffer status " + std::to_string(status) +
           "); lower the resolution");
    width = new_width;
    height = new_height;
    coloured = with_colours;
  }

  void send(const MapFrame& frame, std::span<const Vec3> x, std::span<const Triangle> triangles,
            const VertexColours& colours_of_vertices) {
    upload.assign(kFloats * x.size(), 0.0F);
    const double depth_scale = frame.half[2] > 0.0 ? kDepthRange / frame.half[2] : 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3 p = frame.place(x[i]);
      float* out = upload.data() + kFloats * i;
      out[0] = static_cast<float>(2.0 * p[0] / frame.width - 1.0);
      out[1] = static_cast<float>(2.0 * p[1] / frame.height - 1.0);
      out[2] = static_cast<float>(p[2] * depth_scale);
      for (int k = 0; k < 3; ++k) {
        if (!colours_of_vertices.normal.empty())
          out[3 + k] = static_cast<float>(colours_of_vertices.normal[i][k]);
        if (!colours_of_vertices.motion.empty())
          out[6 + k] = static_cast<float>(colours_of_vertices.motion[i][k]);
      }
    }
    mesa().glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(upload.size() * sizeof(float)),
                        upload.data(), GL_STREAM_DRAW);
    mesa().glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size_bytes()),
                        triangles.data(), GL_STREAM_DRAW);
    for (GLuint k = 0; k < 3; ++k) {
      mesa().glEnableVertexAttribArray(k);
      mesa().glVertexAttribPointer(k, 3, GL_FLOAT, GL_FALSE, kFloats * sizeof(float),
                                   reinterpret_cast<const void*>(3 * k * sizeof(float)));
    }
  }

  /// The outermost layer: of greatest depth along `toward` if `is_front`, otherwise of least.
  void draw_layer(std::size_t triangles, bool is_front) {
    const GLint nothing = -1;
    const std::array<GLfloat, 4> black{};
    const GLfloat farthest = is_front ? 0.0F : 1.0F;
    mesa().glClearBufferiv(GL_COLOR, 0, &nothing);
    for (GLint k = 1; coloured && k < 3; ++k) mesa().glClearBufferfv(GL_COLOR, k, black.data());
    mesa().glClearBufferfv(GL_DEPTH, 0, &farthest);
    mesa().glDepthFunc(is_front ? GL_GREATER : GL_LESS);
    mesa().glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * triangles), GL_UNSIGNED_INT,
                          nullptr);
  }

  void read(Layer& layer) const {
    const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    layer.triangle.resize(texels);
    mesa().glReadBuffer(GL_COLOR_ATTACHMENT0);
    mesa().glReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_INT, layer.triangle.data());
    layer.normal_depth.resize(coloured ? 4 * texels : 0);
    layer.motion.resize(coloured ? 4 * texels : 0);
    if (!coloured) return;
    mesa().glReadBuffer(GL_COLOR_ATTACHMENT1);
    mesa().glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, layer.normal_depth.data());
    mesa().glReadBuffer(GL_COLOR_ATTACHMENT2);
    mesa().glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, layer.motion.data());
  }
};

OffscreenRenderer::OffscreenRenderer() : context_(std::make_unique<Context>()) {}
OffscreenRenderer::~OffscreenRenderer() = default;

void OffscreenRenderer::draw(const MapFrame& frame, std::span<const Vec3> x,
                             std::span<const Triangle> triangles, const VertexColours& colours,
                             Layer& front, Layer& back) {
  const Context::Current current(*context_);
  const bool coloured = !colours.normal.empty();
  context_->resize(frame.width, frame.height, coloured);
  context_->send(frame, x, triangles, colours);
  mesa().glUseProgram(coloured ? context_->program : context_->index_program);
  mesa().glViewport(0, 0, frame.width, frame.height);
  mesa().glEnable(GL_DEPTH_TEST);
  for (const bool is_front : {true, false}) {
    context_->draw_layer(triangles.size(), is_front);
    context_->read(is_front ? front : back);
  }
  check_errors("draws");
}

}  // namespace selvedge::detail
