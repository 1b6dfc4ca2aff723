// Recorded Fastrak poses: consecutive 4 x 4 matrices in text, m.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "core/math/types.h"

namespace godobject::test {

inline std::vector<Pose> read_matrices(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::vector<Pose> poses;
  Eigen::Matrix4d X;
  for (;;) {
    for (Eigen::Index row = 0; row < 4; ++row) {
      for (Eigen::Index column = 0; column < 4; ++column) in >> X(row, column);
    }
    if (!in) return poses;
    poses.push_back({.p = X.topRightCorner<3, 1>(), .q = Quat(Mat3(X.topLeftCorner<3, 3>())).normalized()});
  }
}

/// Returns the recorded files of a folder, sorted by name.
inline std::vector<std::filesystem::path> files_with(const std::filesystem::path& folder,
                                                     const char* extension) {
  std::vector<std::filesystem::path> files;
  if (folder.empty()) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace godobject::test
