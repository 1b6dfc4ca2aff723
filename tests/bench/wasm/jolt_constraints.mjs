// Joints and couplings of a scene as Jolt's constraints between two bodies, or a body and the world.
import { X, Y } from './math.mjs';

const axes = ['TranslationX', 'TranslationY', 'TranslationZ', 'RotationX', 'RotationY', 'RotationZ'];

// Free axes of the six-axis constraint and its axes X (twist) and Y in parent and child: for joints of the scenes.
const kinds = {
  ball: () => ({ free: ['RotationX', 'RotationY', 'RotationZ'], x: X, y: Y }),
  universal: (joint) => ({ free: ['RotationX', 'RotationY'], x: joint.axis_C, y: joint.axis_P }),
  cylindrical: (joint) => ({ free: ['TranslationX', 'RotationX'], x: joint.axis_P, y: Y }),
  hinge: (joint) => ({ free: ['RotationX'], x: joint.axis_P, y: Y }),
};

function frame(run, settings, { x, y, p1, p2 }) {
  const { jolt } = run;
  settings.mSpace = jolt.EConstraintSpace_LocalToBodyCOM;
  settings.mPosition1 = run.at(p1);
  settings.mPosition2 = run.at(p2);
  settings.mAxisX1 = settings.mAxisX2 = run.vec(x);
  settings.mAxisY1 = settings.mAxisY2 = run.vec(y, 1);
}

/** Adds a joint between bodies of the scene. */
export function addConstraint(run, joint) {
  const { jolt } = run, { free, x, y } = kinds[joint.type](joint), settings = new jolt.SixDOFConstraintSettings();
  frame(run, settings, { x, y: y === x ? X : y, p1: joint.anchor_P, p2: joint.anchor_C });
  for (const axis of axes) {
    const number = jolt[`SixDOFConstraintSettings_EAxis_${axis}`];
    if (free.includes(axis)) settings.MakeFreeAxis(number);
    else settings.MakeFixedAxis(number);
  }
  const parent = joint.parent === null ? run.world.sGetFixedToWorldBody() : run.bodies[joint.parent];
  run.system.AddConstraint(settings.Create(parent, run.bodies[joint.child]));
  jolt.destroy(settings);
}

/** Adds the motors that hold a body at its target. */
export function addCoupling(run, target, body, { k, g, k_r, g_r }) {
  const { jolt } = run, settings = new jolt.SixDOFConstraintSettings();
  frame(run, settings, { x: X, y: Y, p1: [0, 0, 0], p2: [0, 0, 0] });
  axes.forEach((axis, i) => {
    const motor = settings.get_mMotorSettings(i), spring = motor.mSpringSettings;
    spring.mMode = jolt.ESpringMode_StiffnessAndDamping;
    spring.mStiffness = i < 3 ? k : k_r;
    spring.mDamping = i < 3 ? g : g_r;
    motor.mSpringSettings = spring;
    settings.set_mMotorSettings(i, motor);
    settings.MakeFreeAxis(jolt[`SixDOFConstraintSettings_EAxis_${axis}`]);
  });
  const constraint = jolt.castObject(settings.Create(target, body), jolt.SixDOFConstraint);
  for (const axis of axes)
    constraint.SetMotorState(jolt[`SixDOFConstraintSettings_EAxis_${axis}`], jolt.EMotorState_Position);
  run.system.AddConstraint(constraint);
  jolt.destroy(settings);
}
