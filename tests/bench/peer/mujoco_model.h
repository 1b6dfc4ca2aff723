// A model of MuJoCo from the text of a model file.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstring>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tests/oracle/case/case.h"

namespace godobject::bench {

inline std::string numbers(const oracle::Vector3d& a) {
  std::ostringstream text;
  text.precision(17);
  text << a.x() << ' ' << a.y() << ' ' << a.z();
  return text.str();
}

/// Throws std::runtime_error with MuJoCo's message.
inline mjModel* load(const std::string& xml) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  std::array<char, 500> error{};
  mjModel* const model = mj_loadXML("model.xml", files.get(), error.data(), static_cast<int>(error.size()));
  mj_deleteVFS(files.get());
  if (model == nullptr) throw std::runtime_error(error.data());
  return model;
}

}  // namespace godobject::bench
