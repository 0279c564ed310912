// SPDX-License-Identifier: MIT
#include <png.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/pictures/picture_files.h>

#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

/// libpng reports errors through callbacks. An exception must not pass through its C frames, so the
/// callback stores the message here and leaves libpng by its own longjmp.
struct PngSink {
  std::vector<png_byte> bytes;
  std::string fault;
};

void on_error(png_structp png, png_const_charp message) {
  static_cast<PngSink*>(png_get_error_ptr(png))->fault = message;
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_bytes(png_structp png, png_bytep data, png_size_t count) {
  auto* sink = static_cast<PngSink*>(png_get_io_ptr(png));
  try {
    sink->bytes.insert(sink->bytes.end(), data, data + count);
  } catch (const std::bad_alloc&) {
    png_error(png, "out of memory");
  }
}

void on_flush(png_structp) {}

/// Encodes between setjmp and a possible longjmp. This frame must therefore hold no object with a
/// destructor.
bool encode(png_structp png, png_infop info, PngSink& sink, const Image& image) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &sink, on_bytes, on_flush);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  const std::size_t stride = 3 * static_cast<std::size_t>(image.width);
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row)
    png_write_row(png, image.rgb.data() + row * stride);
  png_write_end(png, info);
  return true;
}

}  // namespace

void write_png(const std::filesystem::path& file, const Image& image) {
  if (image.width < 1 || image.height < 1 ||
      image.rgb.size() !=
          3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height))
    throw std::invalid_argument("image for " + file.string() + " has not width x height pixels");
  PngSink sink;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool done = info != nullptr && encode(png, info, sink, image);
  png_destroy_write_struct(&png, &info);
  if (!done)
    throw std::runtime_error("cannot encode " + file.string() + ": " +
                             (sink.fault.empty() ? "out of memory" : sink.fault));
  AtomicFile out(file);
  out.write(sink.bytes.data(), sink.bytes.size());
  out.commit();
}

}  // namespace selvedge
