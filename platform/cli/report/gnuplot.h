// Pictures that gnuplot draws. It is another program, which need not be installed.
#pragma once

#include <string>
#include <string_view>

namespace godobject {

/// True if a picture of this name can be drawn: it ends in .svg or .png.
bool is_plot(std::string_view path) noexcept;

/// Returns the text as a string of gnuplot.
std::string gnuplot_text(std::string_view text);

/// Runs a script on gnuplot. Writes its picture of this size, pixels, to a file for which is_plot() holds.
/// Returns the error with its remedy; empty on success.
std::string draw_plot(const std::string& path, int width, int height, const std::string& script);

}  // namespace godobject
