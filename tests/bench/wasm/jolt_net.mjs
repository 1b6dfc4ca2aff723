// The net S6 in Jolt: a soft body whose edges have the springs' compliance. Edges have no damper, nodes have that
// of the air.
import { isHeld, springsOf, startOf } from './net.mjs';

export class JoltNet {
  /** world: a Jolt world with gravity, its interface and layer for bodies. */
  constructor({ jolt, world, bodies, layer }, net, iterations) {
    Object.assign(this, { jolt, world, net });
    const shared = new jolt.SoftBodySharedSettings(), vertex = new jolt.SoftBodySharedSettingsVertex();
    for (let n = 0; n < net.across * net.down; ++n) {
      const place = new jolt.Float3(...startOf(net, n));
      vertex.mPosition = place;
      vertex.mInvMass = isHeld(net, n) ? 0 : 1 / net.m;
      shared.mVertices.push_back(vertex);
      jolt.destroy(place);
    }
    for (const [i, j] of springsOf(net)) {
      const edge = new jolt.SoftBodySharedSettingsEdge(i, j, 1 / net.k);
      shared.mEdgeConstraints.push_back(edge);
      jolt.destroy(edge);
    }
    shared.CalculateEdgeLengths();
    shared.Optimize();
    const origin = new jolt.RVec3(0, 0, 0), attitude = new jolt.Quat(0, 0, 0, 1);
    const settings = new jolt.SoftBodyCreationSettings(shared, origin, attitude, layer);
    Object.assign(settings, { mUpdatePosition: false, mAllowSleeping: false });
    settings.mNumIterations = iterations;
    settings.mLinearDamping = net.g_air / net.m;
    this.body = bodies.CreateSoftBody(settings);
    bodies.AddBody(this.body.GetID(), jolt.EActivation_Activate);
    this.vertices = jolt.castObject(this.body.GetMotionProperties(), jolt.SoftBodyMotionProperties).GetVertices();
  }

  step() {
    this.world.Step(this.net.h, 1);
  }

  node(n) {
    const p = this.vertices.at(n).mPosition;
    return [p.GetX(), p.GetY(), p.GetZ()];
  }

  free() {
    this.jolt.destroy(this.world);
  }
}
