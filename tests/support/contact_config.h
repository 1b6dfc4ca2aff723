// Components of scenes with contacts, by value.
#pragma once

#include <string>
#include <utility>

#include "platform/scene/scene.h"

namespace godobject {

inline BodyConfig body_of(const std::string& name, double mass, double inertia) {
  BodyConfig body;
  body.name = name;
  body.mass = mass;
  body.inertia = inertia * Mat3::Identity();
  return body;
}

inline SphereConfig sphere_of(double radius, const Vec3& p_B = Vec3::Zero()) {
  SphereConfig sphere;
  sphere.radius = radius;
  sphere.p_B = p_B;
  return sphere;
}

inline ObstacleConfig obstacle_of(const std::string& name, ShapeKind kind) {
  ObstacleConfig obstacle;
  obstacle.name = name;
  obstacle.shape.kind = kind;
  return obstacle;
}

inline ContactConfig default_contact(double stiffness) {
  ContactConfig contact;
  contact.materials = {default_material, default_material};
  contact.law.k = contact.law.k_t = stiffness;
  return contact;
}

inline JointConfig hinge_of(const std::string& parent, const std::string& child) {
  JointConfig joint;
  joint.name = "hinge";
  joint.parent = parent;
  joint.child = child;
  joint.coordinates = {joint.name};
  return joint;
}

}  // namespace godobject
