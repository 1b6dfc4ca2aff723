// Setup of the points of shapes that spheres of their body round, before the first step.
#pragma once

#include "core/contact/contact.h"
#include "core/shape/points.h"

namespace godobject {

/// Returns the bits of the points of a surface that spheres of its body round.
template <std::size_t max_spheres, std::size_t max_surfaces>
std::uint8_t rounded_points(const ContactParams<max_spheres, max_surfaces>& par,
                            const Surface& surface) noexcept {
  unsigned rounded = 0;
  for (std::size_t s = 0; s < par.num_spheres; ++s) {
    const BodySphere& sphere = par.spheres[s];
    if (surface.body == world || sphere.body != surface.body) continue;
    const Vec3 p_S = to_body(surface.shape.X_WS.q, sphere.p_B - surface.shape.X_WS.p);
    for (std::uint32_t j = 0; j < num_points(surface.shape.kind); ++j)
      if (rounds(p_S, sphere.radius, surface.shape, j)) rounded |= 1u << j;
  }
  return static_cast<std::uint8_t>(rounded);
}

/// Marks the points of all surfaces that spheres round. Call it after the last sphere and surface is set.
template <std::size_t max_spheres, std::size_t max_surfaces>
void mark_rounded_points(ContactParams<max_spheres, max_surfaces>& par) noexcept {
  for (std::size_t o = 0; o < par.num_surfaces; ++o)
    par.surfaces[o].rounded = rounded_points(par, par.surfaces[o]);
}

}  // namespace godobject
