// Errors and faults as exceptions of the Python package (godobject.errors).
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "platform/cli/fault_texts.h"
#include "platform/scene/table.h"
#include "platform/session/record.h"

namespace py = pybind11;

namespace godobject {

/// Errors of a scene or a motion, thrown as the Python exception of this name of godobject.errors.
struct Refused {
  const char* exception;
  std::vector<PlacedText> errors;
};

/// Returns an error with the place at the beginning of its text: "file:line:column: ", both numbers optional.
/// Others are of the whole file.
inline PlacedText with_place(const std::string& error, const std::string& file) {
  static const std::regex place(R"(^([^:]+):(?:(\d{1,9}):(?:(\d{1,9}):)?)? )");
  std::smatch found;
  std::error_code ignored;
  if (!std::regex_search(error, found, place) ||
      (found[1] != file && !std::filesystem::exists(found[1].str(), ignored)))
    return {.file = file, .at = {}, .text = error};
  if (!found[2].matched) return {.file = found[1], .at = {}, .text = found.suffix()};
  const TextPosition at{.line = static_cast<std::uint32_t>(std::stoul(found[2])),
                        .column = found[3].matched ? static_cast<std::uint32_t>(std::stoul(found[3])) : 0};
  return {.file = found[1], .at = at, .text = found.suffix()};
}

/// Throws the errors, if there are any. placed: the same with their places, as far as they have some.
inline void refuse(const char* exception, const std::string& file, const std::vector<std::string>& errors,
                   std::vector<PlacedText> placed = {}) {
  if (errors.empty()) return;
  if (placed.empty())
    for (const std::string& error : errors) placed.push_back(with_place(error, file));
  throw Refused{exception, std::move(placed)};
}

/// Returns the arguments of a Problem of godobject.errors for each text.
inline py::list problems(const std::vector<PlacedText>& texts) {
  py::list list;
  for (const PlacedText& text : texts) {
    const py::object line = text.at ? py::cast(text.at->line) : py::none();
    const py::object column = text.at && text.at->column > 0 ? py::cast(text.at->column) : py::none();
    list.append(py::make_tuple(text.text, text.file, line, column));
  }
  return list;
}

inline void raise(const Refused& refused) {
  const py::object type = py::module_::import("godobject.errors").attr(refused.exception);
  PyErr_SetObject(type.ptr(), type(problems(refused.errors)).ptr());
}

using FaultBits = std::uint64_t;  // Fault, RigFault shifted by 32, and those of the run

inline constexpr FaultBits unreachable_bit = FaultBits{1} << 62, oscillates_bit = FaultBits{1} << 63;

/// Returns the texts of the faults of a step, each with its bit.
inline std::vector<std::pair<FaultBits, FaultText>> fault_texts() {
  std::vector<std::pair<FaultBits, FaultText>> texts;
  for (const CoreFaultText& core : core_fault_texts)
    texts.emplace_back(static_cast<std::uint32_t>(core.fault), core.text);
  for (const RigFaultText& rig : rig_fault_texts())
    texts.emplace_back(FaultBits{static_cast<std::uint32_t>(rig.fault)} << 32,
                       FaultText{rig.name, rig.meaning, rig.remedy});
  texts.emplace_back(unreachable_bit, text_of(RunFault::unreachable));
  texts.emplace_back(oscillates_bit, text_of(RunFault::force_oscillates));
  return texts;
}

[[noreturn]] inline void raise_fault(double t, const std::vector<FaultText>& faults) {
  py::list texts;
  for (const FaultText& fault : faults) texts.append(py::make_tuple(fault.name, fault.meaning, fault.remedy));
  const py::object type = py::module_::import("godobject.errors").attr("FaultError");
  PyErr_SetObject(type.ptr(), type(t, texts).ptr());
  throw py::error_already_set();
}

}  // namespace godobject
