// Python module godobject._core. platform/python/godobject/scene.py extends its session.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "platform/python/input_log.h"
#include "platform/python/session.h"

namespace godobject {
namespace {

template <class Of>
std::vector<std::string> names(const std::vector<Of>& all) {
  std::vector<std::string> list;
  for (const Of& one : all) list.push_back(one.name);
  return list;
}

void add_views(py::class_<PySession>& type) {
  for (std::size_t k = 0; k < body_quantities.size(); ++k)
    type.def_property_readonly(
        body_quantities[k].name,
        [k](const py::object& self) {
          const auto& session = self.cast<const PySession&>();
          const std::size_t bodies = session.scene().bodies.size();
          return view(session.body_numbers(k), {length(bodies), length(body_quantities[k].width)}, self);
        },
        body_quantities[k].about);
  type.def_property_readonly("joint_coordinates", [](const py::object& self) {
    const Numbers& q = self.cast<const PySession&>().joint_numbers();
    return view(q, {length(q.size())}, self);
  });
  type.def_property_readonly("net_nodes", [](const py::object& self) {
    const Numbers& nodes = self.cast<const PySession&>().net_nodes();
    return view(nodes, {length(nodes.size() / 3), 3}, self);
  });
}

PYBIND11_MODULE(_core, module) {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Refused& refused) {
      raise(refused);
    }
  });
  module.def("keys_of_dict", &keys_of_dict, py::arg("scene"), py::arg("file"), py::arg("plain"));
  module.def("read_input_log", &read_input_log, py::arg("path"));
  py::class_<PySession> type(module, "Session");
  type.def(py::init<const std::string&, const std::optional<py::dict>&, const py::function&,
                    const std::string&, bool>(),
           py::arg("path"), py::arg("parts"), py::arg("plain"), py::arg("bus"), py::arg("raises_faults"))
      .def("_reset", &PySession::reset, py::arg("motion"), py::arg("file"))
      .def("_step", &PySession::step, py::arg("n"), py::arg("every"))
      .def("_num_steps", &PySession::num_steps, py::arg("duration"))
      .def("_contacts", [](const py::object& self) { return self.cast<const PySession&>().contacts(self); })
      .def_property_readonly("_warnings", &PySession::warnings)
      .def_property_readonly("faults", &PySession::faults,
                             "name of each fault since the start: time of the first, s")
      .def_property_readonly("limits", &PySession::limits,
                             "name of each limit that was active since the start: number of steps")
      .def_property_readonly("state_hash", &PySession::state_hash)
      .def_property_readonly("name", [](const PySession& s) { return s.scene().name; })
      .def_property_readonly("step_s", [](const PySession& s) { return s.scene().step; })
      .def_property_readonly("bodies", [](const PySession& s) { return names(s.scene().bodies); })
      .def_property_readonly("joints", [](const PySession& s) { return names(s.scene().joints); })
      .def_property_readonly("targets", [](const PySession& s) { return motion_targets(s.scene()); })
      .def_property_readonly("steps", [](const PySession& s) { return s.shown().cycle; })
      .def_property_readonly("t", [](const PySession& s) { return s.shown().t; })
      .def_property_readonly("energy", [](const PySession& s) { return s.shown().energy.total; });
  add_views(type);
}

}  // namespace
}  // namespace godobject
