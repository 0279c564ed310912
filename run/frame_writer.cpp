// SPDX-License-Identifier: MIT
#include <selvedge/run/frame_writer.h>

namespace selvedge {

// Each is defined in frame_writer_NAME.cpp. To add a format, write that file and two lines here.
FrameFormat obj_format();
FrameFormat pc2_format();
FrameFormat ply_format();
FrameFormat vtk_format();

FrameFormats frame_formats() {
  return {
      {"obj", obj_format()},
      {"pc2", pc2_format()},
      {"ply", ply_format()},
      {"vtk", vtk_format()},
  };
}

}  // namespace selvedge
