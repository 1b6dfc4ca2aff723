// Quantities of a state as NumPy arrays: names, widths, and how they are written.
#pragma once

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "platform/engine/engine.h"

namespace py = pybind11;

namespace godobject {

inline void write(const Vec3& a, double* to) { std::copy_n(a.data(), 3, to); }
inline void write(const Quat& q, double* to) {
  const std::array wxyz{q.w(), q.x(), q.y(), q.z()};
  std::ranges::copy(wxyz, to);
}
inline void write(const Pose& X, double* to) {
  write(X.p, to);
  write(X.q, to + 3);
}
inline void write(const Wrench& F, double* to) {
  write(F.f, to);
  write(F.tau, to + 3);
}
inline void write(const Twist& V, double* to) {
  write(V.v, to);
  write(V.w, to + 3);
}

/// Quantity of each body: name, numbers of a body, the function that writes them, and the text of the view.
struct BodyQuantity {
  const char* name;
  std::size_t width;
  void (*write)(const BodyView& body, double* to);
  const char* about;
};

inline constexpr std::array body_quantities{
    BodyQuantity{"positions", 3, [](const BodyView& b, double* to) { write(b.X_WB.p, to); },
                 "of the bodies' origins, m"},
    BodyQuantity{"quaternions", 4, [](const BodyView& b, double* to) { write(b.X_WB.q, to); }, "w, x, y, z"},
    BodyQuantity{"twists", 6, [](const BodyView& b, double* to) { write(b.V_WB, to); },
                 "velocity, m/s, and angular velocity, rad/s"},
    BodyQuantity{"coupling_wrenches", 6, [](const BodyView& b, double* to) { write(b.coupling_B, to); },
                 "of the couplings on the bodies, about their origins: N, N m"},
    BodyQuantity{"feedback_wrenches", 6, [](const BodyView& b, double* to) { write(b.feedback_D, to); },
                 "displayed, about the targets' origins: N, N m"},
    BodyQuantity{"contact_wrenches", 6, [](const BodyView& b, double* to) { write(b.contact_W, to); },
                 "sums of the contacts, about the origins, mean over the step: N, N m"},
    BodyQuantity{"joint_wrenches", 6, [](const BodyView& b, double* to) { write(b.joint_C, to); },
                 "of each body's joint on it, about the joint's anchor, mean over the step: N, N m"},
    BodyQuantity{"target_positions", 3, [](const BodyView& b, double* to) { write(b.target.X_WD.p, to); },
                 "m; without meaning for a body without a coupling"},
    BodyQuantity{"target_quaternions", 4, [](const BodyView& b, double* to) { write(b.target.X_WD.q, to); },
                 "w, x, y, z; without meaning for a body without a coupling"},
};

/// Quantity of each contact: name, and member of its view.
struct ContactQuantity {
  const char* name;
  Vec3 ContactView::*of;
};

inline constexpr std::array contact_quantities{ContactQuantity{"points", &ContactView::p_W},
                                               ContactQuantity{"normals", &ContactView::n_W},
                                               ContactQuantity{"forces", &ContactView::F_W}};

using Numbers = std::vector<double>;
using Shape = std::vector<py::ssize_t>;

/// Contacts of a state, in memory that stays in place, as views need it.
class ContactNumbers {
 public:
  /// num: largest number of contacts, the same in each call.
  void reserve(std::size_t num) {
    for (Numbers& numbers : numbers_) numbers.resize(3 * num);
  }
  /// Writes the contacts; rows beyond them become zero.
  void show(std::span<const ContactView> contacts) {
    for (std::size_t k = 0; k < numbers_.size(); ++k) {
      for (std::size_t i = 0; i < contacts.size(); ++i)
        write(contacts[i].*contact_quantities[k].of, &numbers_[k][3 * i]);
      for (std::size_t i = 3 * contacts.size(); i < 3 * num_shown_; ++i) numbers_[k][i] = 0;
    }
    num_shown_ = contacts.size();
  }
  const Numbers& of(std::size_t quantity) const { return numbers_[quantity]; }

 private:
  std::array<Numbers, contact_quantities.size()> numbers_;
  std::size_t num_shown_ = 0;
};

/// Returns a read-only array of the numbers, which are in the memory of the owner.
inline py::array view(const Numbers& numbers, const Shape& shape, const py::object& owner) {
  py::array_t<double> array(shape, numbers.data(), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// Returns a read-only array that owns the numbers.
inline py::array array_of(Numbers numbers, const Shape& shape) {
  auto* const owned = new Numbers(std::move(numbers));
  return view(*owned, shape, py::capsule(owned, [](void* p) { delete static_cast<Numbers*>(p); }));
}

inline py::ssize_t length(std::size_t n) { return static_cast<py::ssize_t>(n); }

}  // namespace godobject
