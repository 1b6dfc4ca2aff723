// PNG files, still or animated (APNG), of 8-bit RGB.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace godobject {

struct Image {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // row by row, 3 bytes a pixel
};

/// Returns the bytes of the file. Several images, all of one size, make an animation that repeats. seconds:
/// duration of each image, s.
std::string png_of(const std::vector<Image>& images, double seconds = 0.1);

}  // namespace godobject
