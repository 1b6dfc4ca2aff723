// Places of the two bodies of four contacts at the predicted end of a stage, for their anchors (51).
#pragma once

#include "core/contact/anchors.h"
#include "core/contact/find/world_geometry.h"

namespace godobject {

/// Places and velocities of the bodies of a group at the predicted end of the stage, for four contacts.
/// first: the body whose twist is used. other: the body that it touches, or the world.
template <class Contacts, std::size_t N>
class GroupPlaces {
 public:
  GroupPlaces(std::uint32_t first, std::uint32_t other, const ContactFinder<Contacts, N>& w) noexcept {
    at_.p_a = w.at[first].p_W.template cast<Pack>();
    at_.R_a = w.at[first].R_WB.template cast<Pack>();
    first_ = &w.at[first];
    if (Contacts::between_bodies && other < N) {
      other_ = &w.at[other];
      at_.p_b = other_->p_W.template cast<Pack>();
      at_.R_b = other_->R_WB.template cast<Pack>();
    }
  }
  const Vector3<Pack>& p_W() const noexcept { return at_.p_a; }

  /// Returns the places of the touching and touched bodies, valid until the next call. side: 1 for contacts
  /// whose touching body is the first, otherwise -1.
  const ContactPlacesOf<Pack>& of(const Pack& side) noexcept {
    if constexpr (Contacts::between_bodies) {
      const auto swapped = side < 0;
      if (!any(swapped)) return at_;
      for (Eigen::Index k = 0; k < 3; ++k) {
        mixed_.p_a[k] = select(swapped, at_.p_b[k], at_.p_a[k]);
        mixed_.p_b[k] = select(swapped, at_.p_a[k], at_.p_b[k]);
      }
      for (Eigen::Index k = 0; k < 9; ++k) {
        mixed_.R_a.data()[k] = select(swapped, at_.R_b.data()[k], at_.R_a.data()[k]);
        mixed_.R_b.data()[k] = select(swapped, at_.R_a.data()[k], at_.R_b.data()[k]);
      }
      return mixed_;
    }
    return at_;
  }
  /// Returns the predicted velocities of points of the first body against the other.
  Vector3<Pack> velocity(const Vector3<Pack>& c_W) const noexcept {
    const Vector3<Pack> v_W = velocity_at<Pack>(*first_, c_W);
    return other_ == nullptr ? v_W : Vector3<Pack>(v_W - velocity_at<Pack>(*other_, c_W));
  }

 private:
  ContactPlacesOf<Pack> at_;
  [[no_unique_address]] std::conditional_t<Contacts::between_bodies, ContactPlacesOf<Pack>, None> mixed_;
  const TreePlace *first_ = nullptr, *other_ = nullptr;
};

/// Returns the radius that rolls in a contact (51): that of the touching sphere. Of two spheres or
/// round shapes half the difference, so that the order of their bodies does not matter. Boxes do not roll.
template <std::size_t max_spheres, std::size_t max_surfaces>
Real rolling_radius(const ContactParams<max_spheres, max_surfaces>& par, const NearContact& near) noexcept {
  if (near.of < max_surfaces) {
    const Real a = round_radius(par.surfaces[near.of].shape), b = round_radius(par.surfaces[near.on].shape);
    return a > 0 && b > 0 ? (a - b) / 2 : a - b;
  }
  const Real radius = par.spheres[near.of - max_surfaces].radius;
  return near.on < max_surfaces ? radius : (radius - par.spheres[near.on - max_surfaces].radius) / 2;
}

}  // namespace godobject
