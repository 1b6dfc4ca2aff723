#include "tests/study/figure.h"

#include "tests/study/tool.h"

namespace godobject::study {

std::ofstream script(const std::filesystem::path& directory, const std::string& figure, int width,
                     int height) {
  std::ofstream out(directory / (figure + ".gp"));
  out << "# gnuplot -e \"format='png'\" " << figure << ".gp, in this folder; also svg\n"
      << "if (!exists('format')) format = 'png'\n"
      << "if (format eq 'png') set terminal pngcairo size " << width << ',' << height << " font 'sans,9'\n"
      << "if (format eq 'svg') set terminal svg size " << width << ',' << height
      << " font 'sans,9' background 'white'\n"
      << "set output '" << figure << ".'.format\n"
      << "set datafile separator ','\n";
  return out;
}

std::string draw(const std::filesystem::path& directory, const std::string& figure) {
  for (const std::string format : {"png", "svg"}) {
    const ToolResult run = run_tool({"sh", "-c", "cd \"$1\" && gnuplot -e \"format='$2'\" \"$3\"", "sh",
                                     directory.string(), format, figure + ".gp"});
    if (!run.ok()) return figure + "." + format + ": gnuplot failed: " + run.output;
  }
  return {};
}

}  // namespace godobject::study
