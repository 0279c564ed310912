# SPDX-License-Identifier: MIT
# Formula: brew install --HEAD bindings/ports/homebrew/selvedge.rb
# builds the last commit of the repository that contains it. What was run of it: docs/lab/platforms.md.
class Selvedge < Formula
  desc "Exact cloth collision, and cloth that never passes through anything"
  license "MIT"
  head File.expand_path("../../..", __dir__), using: :git

  depends_on "cmake" => :build
  depends_on "cli11" => :build
  depends_on "ninja" => :build
  depends_on "nlohmann-json" => :build
  depends_on "eigen"
  depends_on "fmt"
  depends_on "gmp"
  depends_on "libpng"
  depends_on "tbb"

  def install
    off = %w[C PYTHON ASSIMP FCL LIBCCD EMBREE OSMESA PAGMO].map { |option| "-DSELVEDGE_#{option}=OFF" }
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DSELVEDGE_UNITY=ON", "-DSELVEDGE_INSTALL=ON", "-DSELVEDGE_APPS=ON", *off, *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    system bin/"selvedge", "run", share/"selvedge/scenes/ring.json", "--out", "drape", "--set", "time.frames=2"
    system bin/"selvedge", "check", "drape"
  end
end
