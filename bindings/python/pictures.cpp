// SPDX-License-Identifier: MIT
//
// Pictures of meshes and of result folders.
#include <pybind11/stl.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/renderer/render.h>
#include <selvedge/pictures/result_pictures.h>

#include <algorithm>

#include "arrays.h"
#include "interruptible.h"
#include "parts.h"

namespace selvedge::python {
namespace {

using Triple = std::array<double, 3>;

Vec3 vec3(const Triple& v) { return {v[0], v[1], v[2]}; }

CameraChoice choice_of(const py::dict& given) {
  CameraChoice choice;
  const auto point = [&](const char* key, std::optional<Vec3>& to) {
    if (!given[key].is_none()) to = vec3(given[key].cast<Triple>());
  };
  point("eye", choice.eye);
  point("target", choice.target);
  if (!given["field_of_view"].is_none())
    choice.field_of_view = given["field_of_view"].cast<double>();
  if (!given["width"].is_none()) choice.width = given["width"].cast<int>();
  if (!given["height"].is_none()) choice.height = given["height"].cast<int>();
  return choice;
}

py::array image_array(Image&& image) {
  const auto height = static_cast<py::ssize_t>(image.height);
  const auto width = static_cast<py::ssize_t>(image.width);
  return own<std::uint8_t>(std::move(image.rgb)).reshape({height, width, py::ssize_t{3}});
}

/// A surface with colours (linear RGB), or (-1, ...) for the usual ones.
struct Drawn {
  Doubles x;
  Whole triangles;
  Triple front, back;
  double crease;
};

Camera camera_for(const CameraChoice& choice, std::span<const RenderSurface> surfaces) {
  Camera camera;
  if (choice.field_of_view) camera.field_of_view = *choice.field_of_view;
  if (choice.width) camera.width = *choice.width;
  if (choice.height) camera.height = *choice.height;
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const RenderSurface& surface : surfaces)
    for (const Vec3& x : surface.x) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
  if (choice.eye) camera.eye = *choice.eye;
  if (choice.target) camera.target = *choice.target;
  if (choice.eye && choice.target) return camera;
  if (choice.target) {
    camera.eye += *choice.target - Camera().target;
    return camera;
  }
  if (!(low.array() <= high.array()).all())
    throw std::invalid_argument("there are no vertices to draw");
  if (choice.eye) {
    camera.target = 0.5 * (low + high);
    return camera;
  }
  return framed(camera, low, high);
}

py::array draw(const std::vector<Drawn>& list, const py::dict& given, bool ground) {
  const CameraChoice choice = choice_of(given);
  return image_array(stoppable([&] {
    std::vector<RenderSurface> surfaces;
    for (const Drawn& drawn : list) {
      RenderSurface& surface = surfaces.emplace_back();
      surface.x = positions(drawn.x, "x");
      surface.triangles = triangles(drawn.triangles, "triangles");
      if (drawn.front[0] >= 0.0) surface.front = vec3(drawn.front);
      if (drawn.back[0] >= 0.0) surface.back = vec3(drawn.back);
      surface.crease = drawn.crease;
    }
    return render(camera_for(choice, surfaces), surfaces, {.ground = ground});
  }));
}

py::array draw_result(const std::string& result, int frame, const py::dict& given) {
  const CameraChoice choice = choice_of(given);
  return image_array(stoppable([&] {
    ResultPictures pictures(result);
    const std::vector<int>& frames = pictures.frames();
    const int shown = frame < 0 ? frames.back() : frame;
    if (std::find(frames.begin(), frames.end(), shown) == frames.end())
      throw std::invalid_argument(result + ": has no frame " + std::to_string(frame) +
                                  "; the last one is " + std::to_string(frames.back()));
    return pictures.picture(shown, pictures.camera(choice, std::array{shown}));
  }));
}

void write_image(const std::string& file, const py::array_t<std::uint8_t, py::array::c_style>& a) {
  if (a.ndim() != 3 || a.shape(2) != 3)
    throw std::invalid_argument("image: must have the shape (height, width, 3)");
  write_png(file, {static_cast<int>(a.shape(1)),
                   static_cast<int>(a.shape(0)),
                   {a.data(), a.data() + a.size()}});
}

}  // namespace

void add_pictures(py::module_& m) {
  py::class_<Drawn>(m, "Drawn")
      .def(py::init([](const Doubles& x, const Whole& t, const Triple& front, const Triple& back,
                       double crease) {
        return Drawn{x, t, front, back, crease};
      }));
  m.def("render", &draw);
  m.def("render_result", &draw_result);
  m.def("write_png", &write_image);
}

}  // namespace selvedge::python
