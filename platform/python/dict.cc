#include "platform/python/dict.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "platform/scene/text/key_writers.h"

namespace py = pybind11;

namespace godobject {
namespace {

/// Key of a table or value, and the tables around it.
struct Place {
  const Place* parent = nullptr;
  std::string_view key{};
  py::ssize_t index = -1;  // of a table in a list; below 0: of no list

  std::string text() const {
    std::string path = parent && parent->parent ? parent->text() + "." : "";
    path += key;
    return index < 0 ? path : path + "[" + std::to_string(index) + "]";
  }
};

std::string_view utf8(py::handle str) {
  py::ssize_t size = 0;
  const char* data = PyUnicode_AsUTF8AndSize(str.ptr(), &size);
  if (!data) throw py::error_already_set();
  return {data, static_cast<std::size_t>(size)};
}

void add_key(std::string_view key, std::string& text) {
  const auto is_bare = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (!key.empty() && std::ranges::all_of(key, is_bare)) text += key;
  else text += TomlWriter::quoted(key);
}

class Writer {
 public:
  Writer(const std::string& file, const py::function& plain, bool with_keys)
      : file_(file), plain_(plain), with_keys_(with_keys) {}

  void table(const py::dict& table, const std::string& header, const Place& place) {
    const Depth depth;
    std::vector<std::pair<std::string_view, py::object>> tables;
    for (const auto& [key, value] : table) {
      if (!py::isinstance<py::str>(key))
        refuse(place, "the key " + std::string(py::repr(key)) + " is not a str");
      const Place own{.parent = &place, .key = utf8(key)};
      py::object converted = plain(value);
      if (is_table(converted)) {
        tables.emplace_back(own.key, std::move(converted));
        continue;
      }
      add_key(own.key, text);
      text += " = ";
      this->value(converted, own);
      end_line(own);
    }
    for (const auto& [key, value] : tables) {
      std::string inner = header.empty() ? "" : header + ".";
      add_key(key, inner);
      if (PyDict_Check(value.ptr())) {
        one_table(value, "[" + inner + "]", inner, {.parent = &place, .key = key});
      } else {
        py::ssize_t i = 0;
        for (const py::handle one : py::reinterpret_borrow<py::sequence>(value)) {
          const Place own{.parent = &place, .key = key, .index = i++};
          one_table(plain(one), "[[" + inner + "]]", inner, own);
        }
      }
    }
  }

  std::string text{};
  py::list keys{};

 private:
  /// Raises Python's RecursionError for dicts that contain themselves.
  struct Depth {
    Depth() {
      if (Py_EnterRecursiveCall(" in a scene of dicts") != 0) throw py::error_already_set();
    }
    ~Depth() { Py_LeaveRecursiveCall(); }
    Depth(const Depth&) = delete;
    Depth& operator=(const Depth&) = delete;
  };

  static bool is_plain(py::handle value) {
    PyObject* p = value.ptr();
    return PyFloat_Check(p) || PyUnicode_Check(p) || PyLong_Check(p) || PyList_Check(p) || PyTuple_Check(p) ||
           PyDict_Check(p);
  }

  py::object plain(py::handle value) const {
    return is_plain(value) ? py::reinterpret_borrow<py::object>(value) : plain_(value);
  }

  /// Raises SceneError.
  [[noreturn]] void refuse(const Place& place, const std::string& message) const {
    const py::object type = py::module_::import("godobject.errors").attr("SceneError");
    py::list problems;
    problems.append(py::make_tuple(message, file_, py::none(), py::none(), place.text()));
    PyErr_SetObject(type.ptr(), type(problems).ptr());
    throw py::error_already_set();
  }

  /// True for a dict, or a list of dicts.
  bool is_table(const py::object& value) const {
    if (PyDict_Check(value.ptr())) return true;
    if (!PyList_Check(value.ptr()) && !PyTuple_Check(value.ptr())) return false;
    const auto list = py::reinterpret_borrow<py::sequence>(value);
    return list.size() > 0 && std::all_of(list.begin(), list.end(), [this](py::handle one) {
             return PyDict_Check(one.ptr()) || (!is_plain(one) && PyDict_Check(plain(one).ptr()));
           });
  }

  void one_table(const py::object& value, const std::string& line, const std::string& header,
                 const Place& own) {
    text += line;
    end_line(own);
    table(py::reinterpret_borrow<py::dict>(value), header, own);
  }

  void value(const py::object& value, const Place& place) {
    PyObject* p = value.ptr();
    if (PyFloat_Check(p)) {
      char* shortest = PyOS_double_to_string(PyFloat_AS_DOUBLE(p), 'r', 0, Py_DTSF_ADD_DOT_0, nullptr);
      if (!shortest) throw py::error_already_set();
      text += shortest;
      PyMem_Free(shortest);
    } else if (PyBool_Check(p)) {
      text += p == Py_True ? "true" : "false";
    } else if (PyLong_Check(p)) {
      text += utf8(py::str(py::int_(value)));
    } else if (PyUnicode_Check(p)) {
      text += TomlWriter::quoted(utf8(value));
    } else if (value.is_none()) {
      refuse(place, "the value is None: leave the key out");
    } else if (!PyList_Check(p) && !PyTuple_Check(p)) {
      const std::string type = py::str(py::type::of(value).attr("__name__"));
      refuse(place, "the value is a " + type + ", which scenes do not have");
    } else {
      const Depth depth;
      text += '[';
      bool is_first = true;
      for (const py::handle one : py::reinterpret_borrow<py::sequence>(value)) {
        if (!std::exchange(is_first, false)) text += ", ";
        this->value(plain(one), place);
      }
      text += ']';
    }
  }

  void end_line(const Place& place) {
    text += '\n';
    if (with_keys_) keys.append(place.text());
  }

  const std::string& file_;
  const py::function& plain_;
  bool with_keys_;
};

/// Builds the tables that the text of a scene has. Its functions return false for a value that needs it.
class Builder {
 public:
  explicit Builder(const py::function& plain) : plain_(plain) {}

  bool table(py::handle dict, toml::table& to) {
    PyObject *key = nullptr, *value = nullptr;
    const Level level(depth_);
    for (Py_ssize_t at = 0; level.is_usual() && PyDict_Next(dict.ptr(), &at, &key, &value);) {
      if (!PyUnicode_Check(key)) return false;
      const auto put = [&, name = utf8(key)](auto&& node) {
        to.insert(name, std::forward<decltype(node)>(node));
        return true;
      };
      if (!add(value, put)) return false;
    }
    return level.is_usual();
  }

 private:
  static constexpr int max_depth = 8;  // of the tables and lists of usual scenes
  class Level {
   public:
    explicit Level(int& depth) : depth_(++depth) {}
    ~Level() { --depth_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;
    bool is_usual() const { return depth_ <= max_depth; }

   private:
    int& depth_;
  };

  bool list(py::handle sequence, toml::array& to) {
    const Level level(depth_);
    const Py_ssize_t size = PySequence_Fast_GET_SIZE(sequence.ptr());
    std::size_t num_tables = 0;
    const auto put = [&](auto&& node) {
      to.push_back(std::forward<decltype(node)>(node));
      return true;
    };
    for (Py_ssize_t i = 0; i < size; ++i) {
      if (!level.is_usual() || !add(PySequence_Fast_GET_ITEM(sequence.ptr(), i), put)) return false;
      if (to.back().is_table()) ++num_tables;
    }
    return num_tables == 0 || num_tables == to.size();
  }

  /// Passes the value to `put`, as a node. Other types of Python are converted.
  template <class Put>
  bool add(py::handle value, Put put) {
    PyObject* const p = value.ptr();
    if (PyFloat_Check(p)) return put(PyFloat_AS_DOUBLE(p));
    if (PyBool_Check(p)) return put(p == Py_True);
    if (PyLong_Check(p)) {
      int overflows = 0;
      const long long n = PyLong_AsLongLongAndOverflow(p, &overflows);
      return overflows == 0 && put(static_cast<std::int64_t>(n));
    }
    if (PyUnicode_Check(p)) return put(std::string(utf8(value)));
    if (PyDict_Check(p)) {
      toml::table inner;
      return table(value, inner) && put(std::move(inner));
    }
    if (PyList_Check(p) || PyTuple_Check(p)) {
      toml::array inner;
      return list(value, inner) && put(std::move(inner));
    }
    const py::object converted = plain_(value);
    return converted.ptr() != p && Level(depth_).is_usual() && add(converted, put);
  }

  const py::function& plain_;
  int depth_ = 0;
};

}  // namespace

std::optional<toml::table> table_of_dict(const py::dict& scene, const py::function& plain) {
  toml::table table;
  return Builder(plain).table(scene, table) ? std::optional(std::move(table)) : std::nullopt;
}

std::string toml_of_dict(const py::dict& scene, const std::string& file, const py::function& plain) {
  Writer writer(file, plain, false);
  writer.table(scene, "", {});
  return std::move(writer.text);
}

py::list keys_of_dict(const py::dict& scene, const std::string& file, const py::function& plain) {
  Writer writer(file, plain, true);
  writer.table(scene, "", {});
  return writer.keys;
}

}  // namespace godobject
